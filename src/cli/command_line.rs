//! The command line as its reader meets it: each command shows its own flags and the settings that it reads, and takes
//! every setting.

use clap::{Arg, CommandFactory, FromArgMatches};

use super::Cli;

/// The settings that a command reads and shows in its help. `serve`, `config` and `doctor` read every one.
const READ: &[(&str, &[&str])] = &[
    ("healthcheck", &["config", "listen", "tls_certificate", "tls_key"]),
    ("keys", &["config", "data_dir"]),
    ("webhooks", &["config", "data_dir"]),
    ("migrate", &["config", "data_dir", "database_password_file", "files"]),
    ("backup", &["config", "data_dir"]),
    ("restore", &["config", "data_dir"]),
    ("doctor", &["config", "data_dir"]),
    ("demo", &["config", "data_dir"]),
    ("config", &["config"]),
    (
        "compensate",
        &[
            "max_cost_s",
            "max_computations",
            "max_body_bytes",
            "max_surface_bytes",
            "max_surface_memory_bytes",
            "max_json_bytes",
            "max_parameters_bytes",
            "max_result_bytes",
        ],
    ),
];
/// The settings that `trunnion -h` shows; `--help` shows every one.
const FIRST: &[&str] = &["config", "listen", "data_dir"];
/// Commands that show every setting.
const SHOWS_ALL: &str = "serve";

const HEADING: &str = "Settings";
const MORE: &str = "Every setting of the service is taken too: trunnion serve --help lists them.";
const ALL: &str = "trunnion serve -h lists every setting, and trunnion COMMAND -h the flags of a command.";

/// What becomes of the settings that a command does not show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Others {
    /// They are taken, and no help shows them.
    Hidden,
    /// They are left out, for scripts that complete words.
    LeftOut,
}

/// The command line with all commands.
#[must_use]
pub fn command() -> clap::Command {
    built(Others::Hidden)
}

/// The command line with only the flags that each command shows.
pub(super) fn shown() -> clap::Command {
    built(Others::LeftOut)
}

fn built(others: Others) -> clap::Command {
    let mut whole = Cli::command();
    let settings: Vec<Arg> = whole.get_arguments().filter(|arg| arg.is_global_set()).cloned().collect();
    let names: Vec<String> = whole.get_subcommands().map(|one| one.get_name().to_owned()).collect();
    for name in names {
        whole = whole.mut_subcommand(&name, |one| with_settings(one, &name, &settings, others));
    }
    whole.after_help(ALL).mut_args(|arg| {
        if !arg.is_global_set() {
            return arg;
        }
        let is_first = FIRST.contains(&arg.get_id().as_str());
        arg.help_heading(HEADING).hide_short_help(!is_first).global(others == Others::Hidden)
    })
}

/// A command with the settings that it shows, and the others as they are wanted.
fn with_settings(mut one: clap::Command, name: &str, settings: &[Arg], others: Others) -> clap::Command {
    let read = READ.iter().find(|(command, _)| *command == name).map_or(&[][..], |(_, read)| read);
    let shows_all = name == SHOWS_ALL;
    for arg in settings {
        let id = arg.get_id().as_str();
        let shown = shows_all || read.contains(&id);
        if shown || others == Others::Hidden {
            let in_short = shows_all || FIRST.contains(&id);
            let arg = arg.clone().help_heading(HEADING).hide(!shown).hide_short_help(!in_short);
            one = one.arg(arg.global(others == Others::Hidden));
        }
    }
    if shows_all { one } else { one.after_long_help(MORE) }
}

/// The arguments of this process.
///
/// # Errors
/// Help or version were asked for, or the arguments are wrong.
pub fn parsed() -> Result<Cli, clap::Error> {
    let mut matches = command().try_get_matches()?;
    Cli::from_arg_matches_mut(&mut matches).map_err(|fault| fault.format(&mut command()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_command_and_setting_exists() {
        let whole = command();
        whole.clone().debug_assert();
        shown().debug_assert();
        let is_setting =
            |id: &str| whole.get_arguments().any(|arg| arg.is_global_set() && arg.get_id() == id);
        for (name, read) in READ {
            assert!(whole.find_subcommand(name).is_some(), "{name}");
            assert!(read.iter().all(|id| is_setting(id)), "{name}: {read:?}");
        }
        assert!(FIRST.iter().all(|id| is_setting(id)));
    }

    #[test]
    fn a_command_shows_its_own_flags_alone_and_takes_every_setting() {
        let mut whole = command();
        for name in ["keys", "migrate", "backup", "restore", "doctor", "compensate", "openapi", "demo"] {
            let help = whole.find_subcommand_mut(name).unwrap().render_help().to_string();
            assert!(!help.contains("--max-") && !help.contains("--webhook"), "{name}: {help}");
            assert_eq!(help.contains("--data-dir"), !["compensate", "openapi"].contains(&name), "{help}");
        }
        for name in ["serve", "compensate"] {
            let help = whole.find_subcommand_mut(name).unwrap().render_long_help().to_string();
            assert!(help.contains("--max-cost-s"), "{help}");
        }
        for typed in [
            &["trunnion", "--max-poses", "7"][..],
            &["trunnion", "--max-poses", "7", "serve"],
            &["trunnion", "serve", "--max-poses", "7"],
            &["trunnion", "openapi", "--max-poses", "7"],
            &["trunnion", "keys", "list", "--max-poses", "7"],
            &["trunnion", "keys", "--max-poses", "7", "list"],
        ] {
            let mut matches = command().try_get_matches_from(typed).unwrap();
            let cli = Cli::from_arg_matches_mut(&mut matches).unwrap();
            assert_eq!(cli.flags.max_poses, Some(7), "{typed:?}");
        }
    }
}
