"""TLS between the service and the server of the database: a certificate is checked as `sslmode` says, and each refusal names
its reason and what helps.

Usage: tls_to_postgres.py PATH_OF_TRUNNION. Needs openssl; the binary needs the feature scale-out.
"""

import pathlib
import shutil
import subprocess
import sys

from plant import Server, free_port, ready, servers, within
from service import Service, workplace

NAME = "localhost"


def openssl(*words):
    done = subprocess.run(["openssl", *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def authority(folder, name):
    """A key and a certificate that sign others."""
    key, certificate = folder / f"{name}.key", folder / f"{name}.pem"
    openssl(
        "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", key, "-out", certificate,
        "-subj", f"/CN={name}", "-days", "30", "-addext", "basicConstraints=critical,CA:TRUE",
    )
    return key, certificate


def certificate(folder, name, signer, host, days=30):
    """A certificate for a host, and its key."""
    key, request, made = (folder / f"{name}.{kind}" for kind in ("key", "csr", "pem"))
    openssl("req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", key, "-out", request, "-subj", f"/CN={host}")
    more = folder / f"{name}.ext"
    more.write_text(f"subjectAltName=DNS:{host}\nbasicConstraints=CA:FALSE\n")
    signing = ["-CA", signer[1], "-CAkey", signer[0], "-CAcreateserial"]
    openssl("x509", "-req", "-in", request, *signing, "-out", made, "-days", days, "-extfile", more)
    return key, made


def present(server, key, made):
    """From its next start on, the server shows this certificate."""
    for source, name in ((key, "server.key"), (made, "server.crt")):
        place = server.place / name
        shutil.copy(source, place)
        place.chmod(0o600)
        if server.place.owner() != "root":
            shutil.chown(place, server.place.owner(), server.place.group())


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    with servers() as place, workplace() as folder:
        server = Server(place, "one").make()
        own, other = authority(folder, "own"), authority(folder, "other")
        good = certificate(folder, "good", own, NAME)
        count = 0

        def service(host, parameters):
            nonlocal count
            count += 1
            address = f"postgres://trunnion@{host}:{server.port}/trunnion?{parameters}"
            more = {"TRUNNION_DATABASE": address, "TRUNNION_FILES": "postgres"}
            return Service(binary, folder / f"data-{count}", free_port(), environment=more)

        def works(host, parameters, protected=True):
            running = service(host, parameters).start()
            seen = server.psql(
                "SELECT DISTINCT ssl FROM pg_stat_ssl JOIN pg_stat_activity USING (pid) WHERE application_name = 'trunnion'"
            )
            assert seen == ("t" if protected else "f"), (parameters, seen)
            running.stop()

        def is_refused(host, parameters, why, cure):
            starting = service(host, parameters).launch()
            status, told = starting.process.wait(30), starting.logged()
            assert status == 2 and why in told and cure in told, (parameters, status, told)

        no_tls = ("does not support TLS", "set ssl = on there")
        for mode in ("require", "verify-full"):
            is_refused(NAME, f"sslmode={mode}&sslrootcert={own[1]}", *no_tls)
        works(NAME, "sslmode=prefer", protected=False)

        server.stop()
        present(server, *good)
        server.set(ssl="on")
        server.start()
        trusting = f"sslmode=verify-full&sslrootcert={own[1]}"
        works(NAME, trusting)
        # No certificate is checked.
        works(NAME, "sslmode=require")
        works("127.0.0.1", "sslmode=require")
        works(NAME, "sslmode=prefer")
        works("127.0.0.1", f"sslmode=verify-ca&sslrootcert={own[1]}")
        is_refused("127.0.0.1", trusting, "not valid for", "use that name in the address")
        unknown = ("UnknownIssuer", "sslrootcert=FILE")
        is_refused(NAME, f"sslmode=verify-full&sslrootcert={other[1]}", *unknown)
        is_refused(NAME, f"sslmode=verify-ca&sslrootcert={other[1]}", *unknown)
        is_refused(NAME, "sslmode=verify-full", *unknown)
        is_refused(NAME, f"sslmode=verify-full&sslrootcert={folder / 'nothing.pem'}", "No such file", "files and the socket")

        # While a service runs, the server gets a certificate that is not trusted, or that is out of date, and then a good one.
        running = service(NAME, trusting).start()
        bad = [
            (certificate(folder, "stranger", other, NAME), "no authority that is trusted has signed its certificate"),
            (certificate(folder, "elsewhere", own, "elsewhere.example"), "its certificate is for another name"),
            (certificate(folder, "old", own, NAME, days=0), "its certificate is not valid at this time"),
        ]
        for shown, why in bad:
            server.stop("immediate")
            present(server, *shown)
            server.start()
            within(15, why, lambda: not ready(running) and why in running.ask("GET", "/readyz").document["detail"])
        server.stop("immediate")
        present(server, *good)
        server.start()
        within(5, "a service whose server has a good certificate again", lambda: ready(running))
        running.stop()
    print(f"TLS to the database: {count} services, each admitted or refused as sslmode says")


main()
