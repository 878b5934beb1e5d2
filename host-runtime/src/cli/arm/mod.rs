//! `tetrad arm`: the arm's kinematics for scripts, CSV in and CSV out.
//!
//! | job | file |
//! |---|---|
//! | a table by the names of its columns, and what is wrong with it | `table` |
//! | joints -> pose | `forward` |
//! | pose -> joints | `inverse` |
//!
//! Rows go out as they come in, so that a program can keep one `tetrad arm ik` open and ask it pose by
//! pose. The first row that makes no sense ends it: the rows before it are answered.

mod forward;
mod inverse;
mod table;

use crate::exit::{Exit, Failure, OrExit as _};
use crate::settings::arm::ArmSettings;
use clap::{Args, Subcommand, ValueEnum};
use std::io;
use std::path::PathBuf;
use table::TableError;
use tetrad_core::arm::puma560::Puma560;
use tetrad_core::geometry::Pose;

pub(super) const EXAMPLES: &str = "\
Examples:
  tetrad arm fk < joints.csv > poses.csv
  tetrad arm ik --in-range < poses.csv > joints.csv
  tetrad arm ik < poses.csv | tetrad arm fk         every solution, and its pose
Metres and radians; the base is the mounting surface, z up; rotations are given row by row.";

const FORWARD_HELP: &str = "\
In:  columns q1 to q6 in any order, radians; other columns are kept as they are.
Out: the same, then x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33. A row whose six angles are all empty
     (one of `tetrad arm ik` without a solution) gets an empty pose.";

const INVERSE_HELP: &str = "\
In:  columns x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33 in any order, and case, the pose's name;
     without that column poses are numbered from 1. Other columns are left out.
Out: case,solution,shoulder,elbow,wrist,q1,q2,q3,q4,q5,q6,in_range,reason
     One row for each of up to eight solutions, numbered from 1: shoulder right or left, elbow up or
     down, wrist no-flip or flip; in_range is true or false. Where there is none, one row with the
     reason and all but case empty.
Of angles that mean the same the one in the joint's range that is nearest to 0 is given.";

/// The flags of `tetrad arm`.
#[derive(Args, Clone, Debug)]
pub(super) struct ArmArgs {
    #[command(subcommand)]
    command: ArmCommand,
}

#[derive(Clone, Debug, Subcommand)]
enum ArmCommand {
    /// Forward kinematics: from joint angles to the pose of the tool
    #[command(after_help = FORWARD_HELP)]
    Fk(KinematicsArgs),
    /// Inverse kinematics: from poses of the tool to all joint angles that bring it there
    #[command(after_help = INVERSE_HELP)]
    Ik {
        #[command(flatten)]
        kinematics: KinematicsArgs,
        /// Only solutions with every joint in its range
        #[arg(long)]
        in_range: bool,
    },
}

#[derive(Args, Clone, Debug)]
struct KinematicsArgs {
    /// Settings of the arm: [arm] of tetrad.toml [default: a PUMA 560]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// What is placed by a pose [default: the tool of --config, which is the flange if none is given]
    #[arg(long, value_enum)]
    tool: Option<Tool>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Tool {
    /// The mounting flange, 56.25 mm from the wrist centre
    Flange,
    /// The wrist centre itself
    None,
}

pub(super) fn run(args: &ArmArgs) -> Result<(), Failure> {
    let (input, output) = (io::stdin().lock(), io::stdout().lock());
    let answered = match &args.command {
        ArmCommand::Fk(kinematics) => forward::convert(&kinematics.arm()?, input, output),
        ArmCommand::Ik { kinematics, in_range } => {
            inverse::convert(&kinematics.arm()?, *in_range, input, output)
        }
    };
    match answered {
        Err(TableError::Unwritten(cause)) if cause.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => {
            let exit = error.exit();
            Err(Failure::new(exit, error))
        }
        Ok(()) => Ok(()),
    }
}

impl KinematicsArgs {
    fn arm(&self) -> Result<Puma560<f64>, Failure> {
        let mut puma = match &self.config {
            Some(file) => ArmSettings::load(file).or_exit(Exit::BadArguments)?.slave.puma,
            None => ArmSettings::default().slave.puma,
        };
        match self.tool {
            Some(Tool::Flange) => puma.tool = tetrad_core::config::PumaConfig::default().tool,
            Some(Tool::None) => puma.tool = Pose::identity(),
            None => {}
        }
        Puma560::new(&puma).or_exit(Exit::BadArguments)
    }
}
