//! The commands, in the groups that `--help` shows.

use anyhow::Result;
use clap::Subcommand;

use super::chart::Chart;
use super::check::Check;
use super::completions::Completions;
use super::describe::Describe;
use super::diff::Diff;
use super::explain::Explain;
use super::extrapolate::Extrapolate;
use super::identities::Identities;
use super::inspect::Inspect;
use super::ladder_map::LadderMap;
use super::man::Man;
use super::new::New;
use super::outcome::Outcome;
use super::paper_table::PaperTable;
use super::pareto::Pareto;
use super::plot::Plot;
use super::profile::Profile;
use super::replay::Replay;
use super::run::Run;
use super::schema::Schema;
use super::stress::Stress;
use super::sweep::Sweep;
use super::trace::Trace;
use super::validate::Validate;

/// Declares groups of commands: one enum per group, which parses its commands, and one enum of all groups, which runs
/// them.
macro_rules! groups {
    ($($title:literal $group:ident { $($command:ident),+ })+) => {
        $(#[derive(Subcommand)]
        pub(super) enum $group {
            $($command($command)),+
        })+

        #[derive(Subcommand)]
        pub(super) enum Command {
            $(#[command(flatten)]
            $group($group)),+
        }

        impl Command {
            /// Runs the command with its arguments.
            pub(super) fn run(self) -> Result<Outcome> {
                match self {
                    $($(Self::$group($group::$command(command)) => command.run()),+),+
                }
            }
        }

        /// The groups in order, each with its title and its commands.
        pub(super) fn groups() -> Vec<(&'static str, clap::Command)> {
            vec![$(($title, $group::augment_subcommands(clap::Command::new($title)))),+]
        }
    };
}

groups! {
    "Simulate" Simulate { Run, Trace, Replay, Profile, Validate }
    "Study" Study { Sweep, Pareto, Stress, LadderMap, Extrapolate, Chart }
    "Paper" Paper { PaperTable, Identities }
    "Look" Look { Inspect, Explain, Plot, Diff }
    "Configs" Configs { New, Check, Describe, Schema }
    "Set up" SetUp { Completions, Man }
}
