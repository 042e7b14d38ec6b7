//! Builds again when a migration is added: the files are compiled into the binary.

fn main() {
    println!("cargo:rerun-if-changed=migrations");
}
