//! The `unframed` command: exit status 0 only when the job was done.

use std::process::ExitCode;

use clap::Parser;
use unframed_cli::args::{Cli, Command, RunArgs};
use unframed_cli::commands::{cost, effects, eval, firmware, inspect, play, record, run, scenes};

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        None => run::run(&main_job()),
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::Record(args)) => record::record(&args),
        Some(Command::Play(args)) => play::play(&args),
        Some(Command::Inspect(args)) => inspect::inspect(&args),
        Some(Command::Scenes(args)) => scenes::scenes(&args),
        Some(Command::Eval(args)) => eval::eval(&args),
        Some(Command::Cost(args)) => cost::cost(&args),
        Some(Command::Effects(args)) => effects::effects(&args),
        Some(Command::Firmware(command)) => firmware::firmware(&command),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// What `unframed` does without a word: the built-in scene, written out.
fn main_job() -> RunArgs {
    let words = ["unframed", "run", "--out", "unframed-out"];
    match Cli::parse_from(words).command {
        Some(Command::Run(args)) => args,
        _ => unreachable!("these words are a run"),
    }
}
