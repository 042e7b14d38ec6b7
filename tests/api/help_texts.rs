//! Help, completions and manual pages, and variables of the environment that are no settings.

use std::process::Output;

use tempfile::TempDir;

use crate::command_line::{path, said};
use crate::process::unset;

fn asked(arguments: &[&str], variables: &[(&str, &str)]) -> Output {
    let mut command = unset();
    command.args(arguments).envs(variables.iter().copied()).output().unwrap()
}

fn text(arguments: &[&str]) -> String {
    let done = asked(arguments, &[]);
    assert!(done.status.success() && done.stderr.is_empty(), "{arguments:?}: {}", said(&done));
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn the_help_of_a_command_is_about_that_command() {
    for (arguments, own, lines) in [
        (&["keys", "create", "-h"][..], "--scopes", 25),
        (&["doctor", "-h"], "--audit-head", 25),
        (&["restore", "-h"], "--data-dir", 20),
        (&["compensate", "-h"], "--preset", 40),
        (&["completions", "-h"], "fish", 15),
    ] {
        let help = text(arguments);
        assert!(help.contains(own) && !help.contains("--webhook-allow"), "{arguments:?}: {help}");
        assert!(help.lines().count() <= lines, "{arguments:?}: {help}");
    }
    let short = text(&["-h"]);
    assert!(short.contains("compensate") && short.contains("--listen") && !short.contains("--max-cost-s"));
    for all in [&["--help"][..], &["serve", "-h"]] {
        assert!(text(all).contains("--max-cost-s"), "{all:?}");
    }
}

#[test]
fn every_shell_completes_the_commands_and_their_own_flags() {
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let script = text(&["completions", shell]);
        for word in ["compensate", "preset", "audit-head", "max-cost-s"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    // A command does not offer what it does not show.
    let bash = text(&["completions", "bash"]);
    let (_, migrate) =
        bash.split_once("trunnion__subcmd__migrate)").or(bash.split_once("trunnion__migrate)")).unwrap();
    let (migrate, _) = migrate.split_once(";;").unwrap();
    assert!(migrate.contains("--data-dir") && !migrate.contains("--max-cost-s"), "{migrate}");
    let unknown = asked(&["completions", "sh"], &[]);
    assert!(unknown.status.code() == Some(2) && said(&unknown).contains("bash"), "{}", said(&unknown));
}

#[test]
fn the_manual_has_a_page_for_each_command() {
    let page = text(&["man"]);
    assert!(page.contains(".TH trunnion 1") && page.contains("TRUNNION_LISTEN"), "{page}");
    let folder = TempDir::new().unwrap();
    let pages = folder.path().join("man1");
    text(&["man", "--all-into", path(&pages)]);
    for name in ["trunnion.1", "trunnion-serve.1", "trunnion-compensate.1", "trunnion-keys-create.1"] {
        assert!(pages.join(name).is_file(), "{name}");
    }
    let one = std::fs::read_to_string(pages.join("trunnion-compensate.1")).unwrap();
    assert!(one.contains("preset") && !one.contains("webhook"), "{one}");
}

#[test]
fn a_variable_that_is_nearly_a_setting_is_refused_and_another_is_named() {
    let data = TempDir::new().unwrap();
    let directory = data.path().join("data");
    let migrate = ["migrate", "--data-dir", path(&directory)];
    let near = asked(&migrate, &[("TRUNNION_DATADIR", "/srv")]);
    assert_eq!(near.status.code(), Some(2), "{}", said(&near));
    assert!(said(&near).contains("TRUNNION_DATADIR is no setting; did you mean TRUNNION_DATA_DIR?"));
    assert!(!directory.exists());
    let links = [
        ("TRUNNION_PORT", "tcp://10.0.0.7:8080"),
        ("TRUNNION_SERVICE_HOST", "10.0.0.7"),
        ("TRUNNION_PORT_8080_TCP_ADDR", "10.0.0.7"),
        ("TRUNNION_COLOUR", "blue"),
    ];
    let told = asked(&migrate, &links);
    assert_eq!(told.status.code(), Some(0), "{}", said(&told));
    let warnings = String::from_utf8(told.stderr).unwrap();
    assert_eq!(warnings.lines().count(), 2, "{warnings}");
    assert!(warnings.contains("TRUNNION_COLOUR is no setting"), "{warnings}");
    assert!(warnings.contains("enableServiceLinks: false"), "{warnings}");
    // Commands that read no setting, and the check that a container repeats, say nothing.
    assert_eq!(asked(&["completions", "fish"], &links).stderr, b"");
    assert!(!said(&asked(&["healthcheck", "--listen", "127.0.0.1:1"], &links)).contains("COLOUR"));
}
