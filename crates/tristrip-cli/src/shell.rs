//! Completions and man pages, generated from the flags.

use clap_complete::Shell;

use crate::args::command_line;

/// Returns the completions of the command for a shell.
pub(crate) fn completions(shell: Shell) -> Vec<u8> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut command_line(), "tristrip", &mut text);
    text
}

/// Returns the man page of the command or of a subcommand.
///
/// # Errors
/// The subcommand is unknown, or the page cannot be rendered.
pub(crate) fn man(subcommand: Option<&str>) -> Result<Vec<u8>, String> {
    let mut command = command_line();
    command.build();
    let page = match subcommand {
        None => command,
        Some(name) => {
            let names =
                || command.get_subcommands().map(clap::Command::get_name).collect::<Vec<_>>().join(", ");
            let unknown = || format!("found subcommand `{name}`, expected one of: {}", names());
            let found = command.find_subcommand(name).ok_or_else(unknown)?;
            found.clone().display_name(format!("tristrip-{name}"))
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text).map_err(|error| error.to_string())?;
    Ok(text)
}
