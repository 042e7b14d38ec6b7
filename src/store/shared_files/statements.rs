//! The rows that name files, wherever their bytes are.

use sqlx::{Connection, Error};

use super::SharedFiles;

row! {
    /// An upload in parts.
    pub(super) struct Upload {
        pub(super) object_key: String,
        pub(super) upload_id: String,
    }
}

row! {
    /// A file that is kept.
    pub(super) struct Kept {
        pub(super) object_key: String,
        pub(super) length: i64,
    }
}

impl SharedFiles {
    /// The file, if it is kept already; it is then kept for another day.
    pub(super) async fn touch(&self, sha256: &str) -> Result<Option<Kept>, Error> {
        let mut connection = self.connections.acquire().await?;
        let touched: Result<Option<Kept>, Error> = postgres!(
            &mut *connection,
            optional(Kept),
            "UPDATE files SET kept_at = clock_timestamp() WHERE sha256 = $1 AND whole = 1
             RETURNING object_key, length",
            sha256
        );
        touched
    }

    /// A new object without bytes.
    pub(super) async fn begin(&self, sha256: &str, length: i64) -> Result<String, Error> {
        let mut connection = self.connections.acquire().await?;
        let object: Result<String, Error> = postgres!(
            &mut *connection,
            one(_),
            "INSERT INTO files (object_key, sha256, length)
             VALUES (CAST($1 AS TEXT) || '-' || CAST(gen_random_uuid() AS TEXT), $1, $2) RETURNING object_key",
            sha256,
            length
        );
        object
    }

    /// Notes the upload of an object that is not whole, or that it has none.
    pub(super) async fn note_upload(&self, object: &str, upload: Option<&str>) -> Result<(), Error> {
        let mut connection = self.connections.acquire().await?;
        let noted: Result<u64, Error> = postgres!(
            &mut *connection,
            execute,
            "UPDATE files SET upload_id = $1 WHERE object_key = $2 AND whole = 0",
            upload,
            object
        );
        noted.map(drop)
    }

    /// Whether the object is whole and stands for its digest from now on, in the place of one whose bytes are not there;
    /// `false` if another one does.
    pub(super) async fn end(
        &self,
        object: &str,
        sha256: &str,
        replaced: Option<&Kept>,
    ) -> Result<bool, Error> {
        let mut connection = self.connections.acquire().await?;
        let mut transaction = connection.begin().await?;
        if let Some(Kept { object_key, .. }) = replaced {
            let done: Result<u64, Error> = postgres!(
                &mut *transaction,
                execute,
                "UPDATE files SET whole = 0 WHERE object_key = $1 AND whole = 1",
                object_key
            );
            done?;
        }
        let done: Result<u64, Error> = postgres!(
            &mut *transaction,
            execute,
            "UPDATE files SET whole = 1, upload_id = NULL, kept_at = clock_timestamp() WHERE object_key = $1
                 AND NOT EXISTS (SELECT 1 FROM files o WHERE o.sha256 = $2 AND o.whole = 1)",
            object,
            sha256
        );
        match done {
            Ok(0) => Ok(false),
            Ok(_) => transaction.commit().await.map(|()| true),
            // The other one was stored between the question and the answer.
            Err(Error::Database(fault)) if fault.is_unique_violation() => Ok(false),
            Err(fault) => Err(fault),
        }
    }

    /// Removes the row of an object that does not stand for its digest; answers its name if it was there.
    pub(super) async fn remove(&self, object: &str) -> Result<Vec<String>, Error> {
        let mut connection = self.connections.acquire().await?;
        let gone: Result<Vec<String>, Error> = postgres!(
            &mut *connection,
            all(_),
            "DELETE FROM files WHERE object_key = $1 AND whole = 0 RETURNING object_key",
            object
        );
        gone
    }

    /// Uploads that began more than a day ago.
    pub(super) async fn uploads(&self) -> Result<Vec<Upload>, Error> {
        let mut connection = self.connections.acquire().await?;
        let begun: Result<Vec<Upload>, Error> = postgres!(
            &mut *connection,
            all(Upload),
            "SELECT object_key, upload_id AS \"upload_id!\" FROM files
             WHERE whole = 0 AND upload_id IS NOT NULL AND kept_at < clock_timestamp() - INTERVAL '1 day'"
        );
        begun
    }

    /// The object that stands for a digest.
    pub(super) async fn whole(&self, sha256: &str) -> Result<Option<String>, Error> {
        let mut connection = self.connections.acquire().await?;
        let object: Result<Option<String>, Error> = postgres!(
            &mut *connection,
            optional(_),
            "SELECT object_key FROM files WHERE sha256 = $1 AND whole = 1",
            sha256
        );
        object
    }

    /// The time of the server of the database a day ago \[s since 1970\].
    pub(super) async fn a_day_ago(&self) -> Result<i64, Error> {
        let mut connection = self.connections.acquire().await?;
        let time_s: Result<i64, Error> = postgres!(
            &mut *connection,
            one(_),
            "SELECT CAST(EXTRACT(EPOCH FROM clock_timestamp() - INTERVAL '1 day') AS BIGINT) AS \"time_s!\""
        );
        time_s
    }

    /// Those of these objects that no row names.
    pub(super) async fn nameless(&self, objects: &str) -> Result<Vec<String>, Error> {
        let mut connection = self.connections.acquire().await?;
        let nameless: Result<Vec<String>, Error> = postgres!(
            &mut *connection,
            all(_),
            "SELECT value AS \"value!\" FROM json_each(CAST($1 AS TEXT))
             WHERE NOT EXISTS (SELECT 1 FROM files WHERE object_key = value)",
            objects
        );
        nameless
    }
}
