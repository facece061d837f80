//! `--help` with the commands in groups, which clap has no setting for.

use std::fmt::Write as _;

use clap::Command;

use super::command::groups;

/// `cli` with a help page that lists the commands group by group, each with the first sentence of its description.
pub(super) fn grouped(cli: Command) -> Command {
    let groups = groups();
    let commands = || groups.iter().flat_map(|(_, group)| group.get_subcommands());
    let width = commands().map(|command| command.get_name().len()).max().unwrap_or_default();
    let mut list = String::new();
    for (title, group) in &groups {
        let _ = writeln!(list, "{title}:");
        for command in group.get_subcommands() {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(list, "  {:width$}  {about}", command.get_name());
        }
        list.push('\n');
    }
    cli.help_template(format!(
        "{{before-help}}{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n\
         {list}Options:\n{{options}}{{after-help}}"
    ))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn help_lists_every_command_once_in_its_group() {
        let mut cli = grouped(crate::cli::Cli::command());
        let help = cli.render_help().to_string();
        for command in cli.get_subcommands().filter(|command| command.get_name() != "help") {
            let line = format!("\n  {} ", command.get_name());
            assert_eq!(help.matches(&line).count(), 1, "{help}");
        }
        let titles =
            ["\nSimulate:\n", "\nStudy:\n", "\nPaper:\n", "\nLook:\n", "\nConfigs:\n", "\nSet up:\n", "\nOptions:\n"];
        let places: Vec<_> = titles.iter().map(|title| help.find(title)).collect();
        assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{help}");
        let list = help.split("\nOptions:").next().unwrap_or_default();
        assert!(list.lines().skip_while(|line| *line != "Simulate:").all(|line| line.len() <= 80), "{help}");
    }
}
