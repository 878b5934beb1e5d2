//! `tetrad keys`: certificates and keys for the stations.

use super::{make_dir, say};
use crate::exit::{Exit, Failure};
use crate::link::StationName;
use crate::link::authority::{KeyFiles, KeysError, make_authority, make_station};
use clap::{Args, Subcommand};
use std::path::PathBuf;

pub(super) const EXAMPLES: &str = "\
Examples:
  Once, on a computer that is kept safe: the authority, then a certificate and a key a station:
    tetrad keys --out keys authority
    tetrad keys --out keys station operator
    tetrad keys --out keys station slave
  Each station gets three files: authority.pem, NAME.pem and NAME.key. authority.key stays where it
  was made: who has it can make any station. Who has NAME.key is that station.";

/// The flags of `tetrad keys`.
#[derive(Args, Clone, Debug)]
pub(super) struct KeysArgs {
    /// The directory of the authority's and the stations' files
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(subcommand)]
    what: What,
}

#[derive(Clone, Debug, Subcommand)]
enum What {
    /// Make the authority that signs the stations' certificates
    Authority,
    /// Make a station's certificate and key, signed by the authority in the same directory
    Station {
        /// What the station is called: lower-case letters, digits and hyphens
        name: StationName,
    },
}

/// Runs `tetrad keys`.
pub(super) fn run(args: &KeysArgs) -> Result<(), Failure> {
    match &args.what {
        What::Authority => {
            make_dir(&args.out)?;
            let files = make_authority(&args.out).map_err(failure)?;
            tell("the authority", &files);
            say("keep authority.key safe and give it to no station; each station needs authority.pem");
        }
        What::Station { name } => {
            let files = make_station(&args.out, name).map_err(failure)?;
            tell(&format!("station {name}"), &files);
            say(format_args!(
                "copy {name}.pem, {name}.key and authority.pem to that station; {name}.key to nobody else"
            ));
        }
    }
    Ok(())
}

fn tell(whose: &str, files: &KeyFiles) {
    say(format_args!("certificate of {whose}: {}", files.certificate.display()));
    say(format_args!("private key of {whose}: {}", files.key.display()));
}

fn failure(error: KeysError) -> Failure {
    let exit = match error {
        KeysError::Exists(_) | KeysError::NoAuthority(_) | KeysError::BadAuthority(..) => Exit::BadArguments,
        KeysError::File { .. } | KeysError::Certificate(_) => Exit::Failed,
    };
    Failure::new(exit, error)
}
