//! `deeptree`: trees from neural networks.

mod args;
mod batch;
mod blend;

mod clouds;
mod dressing;
mod format;
mod input;
mod look;
mod models;
mod output;
mod place;
mod report;
mod stand;
mod surfaces;
mod verbs;

use std::process::ExitCode;

use clap::Parser;

/// Exit codes: 0 done, 1 failed, 2 wrong usage.
const FAILED: u8 = 1;
const USAGE: u8 = 2;

fn main() -> ExitCode {
    let args = match args::Args::try_parse() {
        Ok(args) => args,
        Err(error) if !error.use_stderr() => {
            // Help and version; a closed pipe is the reader's choice.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            eprintln!("deeptree: {}", one_line(&error));
            return ExitCode::from(USAGE);
        }
    };
    match verbs::run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("deeptree: {error:#}");
            ExitCode::from(if error.is::<args::UsageError>() { USAGE } else { FAILED })
        }
    }
}

/// What the command line did not understand, in one line.
fn one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let first = lines.next().unwrap_or_default().trim_start_matches("error: ").to_owned();
    // A list of what is missing stands on the lines below the message.
    let details: Vec<&str> = lines
        .take_while(|line| !line.starts_with("Usage") && !line.starts_with("For more"))
        .collect();
    let joined = [vec![first.as_str()], details].concat().join(" ");
    format!("{joined} (see --help)")
}

/// The reader of our standard output went away, as `head` does.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause
            .downcast_ref::<std::io::Error>()
            .is_some_and(|io| io.kind() == std::io::ErrorKind::BrokenPipe)
    })
}
