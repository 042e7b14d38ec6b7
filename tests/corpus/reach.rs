//! How far the service follows programs that others wrote: whole, in part, not at all; and which construct stops it.
//! The tables are in `docs/evidence.md`; `BLESS=1` writes them again.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Read};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use trunnion::kinematics::Setup;
use trunnion::machine::{
    MAX_REFERENCE_POSITIONS, MachineCoordinates, PlaneRule, PlaneSolution, RotaryLetter,
};
use trunnion::motion::{
    Interpolation, RadiusOffsets, RadiusRegister, StartModes, Unfollowable, WorkOffset, WorkOffsets,
};
use trunnion::process::{
    Interpreted, OpenSubprogram, ProgramSetup, ProgramSource, StartPosition, interpret_program,
};

use trunnion::program::Dialect;

use crate::set_ups::in_mm;
use crate::tables::tables;
use crate::{every_file, shared_file};

/// The folders of programs, and what they are.
const FOLDERS: [(&str, &str); 6] = [
    ("5axis", "five-axis programs and their neighbours"),
    ("other", "ordinary programs"),
    ("cl", "cutter location data, and programs posted from it"),
    ("corpus/linuxcnc-interp", "tests of an RS274/NGC interpreter"),
    ("corpus/cead-sinumerik", "tests of a Sinumerik interpreter"),
    ("corpus/gcode-rs", "samples of a parser"),
];

/// The folder of programs for an RS274/NGC control. The profile of its machine states `rs274_control`.
const RS274: &str = "corpus/linuxcnc-interp";

/// Files that no control runs: results, notes, points, tests of mistakes and of spellings.
const NO_PROGRAMS: [&str; 7] = [
    "README",
    "expected",
    "test.tbl",
    "zhangty_simple_curve_waypoints.txt",
    "LICENSE",
    "gcws_macro7.nc",
    // A list of tokens: bare letters, operators and functions without numbers.
    "gcode-rs/_samples.ngc",
];

/// How far a program is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Reach {
    Whole,
    /// All but motions to reference positions and in machine coordinates: places of the machine, whatever else is known.
    ButForPlaces,
    InPart,
    LeftUnchanged,
    Refused,
    /// It makes no motion.
    Still,
}

/// In the order of the table's columns.
const REACHES: [Reach; 6] =
    [Reach::Whole, Reach::ButForPlaces, Reach::InPart, Reach::LeftUnchanged, Reach::Refused, Reach::Still];

/// A program, how far it is followed, its motions that are followed, and what stops the others.
struct Measured {
    name: String,
    reach: Reach,
    followed: u64,
    in_the_way: BTreeMap<String, u64>,
}

fn is_program(path: &Path) -> bool {
    let text = path.to_string_lossy();
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let is_result = matches!(ending, "csv" | "expected" | "md" | "tbl" | "py" | "json");
    !is_result && !text.contains("/bad/") && !NO_PROGRAMS.iter().any(|name| text.contains(name))
}

/// The rotary axes of a machine that can run it: those that it names.
fn letters(text: &[u8]) -> [RotaryLetter; 2] {
    let is_word = |three: &[u8], letter: u8| {
        !three[0].is_ascii_alphabetic()
            && three[1].eq_ignore_ascii_case(&letter)
            && matches!(three[2], b'0'..=b'9' | b'-' | b'+' | b'.' | b'=')
    };
    let names = |letter: u8| text.windows(3).filter(|three| is_word(three, letter)).count() > 2;
    match (names(b'A'), names(b'B')) {
        (true, true) => [RotaryLetter::A, RotaryLetter::B],
        (false, true) => [RotaryLetter::B, RotaryLetter::C],
        _ => [RotaryLetter::A, RotaryLetter::C],
    }
}

/// How the control interpolates, if the program switches its kinematics by a code of the machine's builder.
fn stated(text: &[u8]) -> Option<Interpolation> {
    let switches = |four: &[u8]| four.eq_ignore_ascii_case(b"M428");
    text.windows(4).any(switches).then_some(Interpolation::Tcp)
}

/// A program with the files of its folder, which it may call.
struct WithNeighbours<'a> {
    text: &'a [u8],
    files: Vec<PathBuf>,
}

/// The folder of subprograms beside a program. The script of the test copies them to a name without this beginning.
const SUBPROGRAMS: &str = "subs";
const COPIED: &str = "orig-";

/// More files than this are no set of programs that call each other.
const MOST_NEIGHBOURS: usize = 20;

impl<'a> WithNeighbours<'a> {
    fn of(path: &Path, text: &'a [u8]) -> Self {
        let is_small = |path: &Path| path.metadata().is_ok_and(|file| file.is_file() && file.len() < 100_000);
        let folder = path.parent().unwrap();
        let entries_of =
            |folder: &Path| folder.read_dir().into_iter().flatten().map(|entry| entry.unwrap().path());
        let entries = entries_of(folder).chain(entries_of(&folder.join(SUBPROGRAMS)));
        let mut files: Vec<_> =
            entries.filter(|other| other != path && is_program(other) && is_small(other)).collect();
        files.sort();
        if files.len() > MOST_NEIGHBOURS {
            files.clear();
        }
        Self { text, files }
    }
}

impl ProgramSource for WithNeighbours<'_> {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(self.text))
    }

    fn open_subprogram(&self, index: usize) -> io::Result<Option<OpenSubprogram<'_>>> {
        let Some(path) = self.files.get(index) else { return Ok(None) };
        let name = path.file_name().unwrap().to_str().unwrap();
        let name = name.strip_prefix(COPIED).unwrap_or(name).to_owned();
        Ok(Some(OpenSubprogram { name, text: Box::new(std::fs::File::open(path)?) }))
    }
}

/// The codes in force at the start, as a profile states them. A Sinumerik begins in G1, unless its builder chose another
/// code. Most other controls return to the initial level after a cycle.
fn start_codes(name: &str) -> &'static str {
    if Path::new(name).extension().is_some_and(|extension| extension == "mpf") { "G1" } else { "G98" }
}

/// Programs whose control is `LinuxCNC`: its tests, and those of its own machines.
fn is_for_rs274(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.to_string_lossy().contains(RS274) || name.starts_with("linuxcnc_")
}

/// The dialect, where the head of a listing does not show it.
fn stated_dialect(path: &Path) -> Option<Dialect> {
    path.to_string_lossy().contains("okuma").then_some(Dialect::Okuma)
}

/// The radius that the request states for each register of the control \[mm\].
const RADIUS_MM: f64 = 1.0;
const MOST_REGISTERS: u16 = 20;

/// The work offsets that the request states.
const OFFSETS: [&str; 16] = [
    "G54", "G55", "G56", "G57", "G58", "G59", "G54.1 P1", "G54.1 P2", "G54.1 P3", "G500", "G505", "G506",
    "PRESET 1", "PRESET 2", "G15 H1", "G15 H2",
];

fn measure(name: String, path: &Path, text: &[u8]) -> Measured {
    let solution = PlaneSolution { rule: PlaneRule::Shortest, axis: None };
    let coordinates = MachineCoordinates {
        zero_mm: [0.0; 3],
        length_counts: Some(false),
        references: vec![[Some(0.0); 5]; MAX_REFERENCE_POSITIONS],
        external_mm: Some([0.0; 3]),
        retract_z_mm: Some(0.0),
    };
    let machine = tables(letters(text), false)
        .with_plane_solution(Some(solution))
        .with_machine_coordinates(Some(coordinates))
        .with_rs274_control(is_for_rs274(path));
    let start = StartPosition { linear_mm: [Some(0.0); 3], rotary_deg: [Some(0.0); 2] };
    let start_modes = StartModes::from_codes(start_codes(&name)).unwrap();
    let program = ProgramSetup {
        dialect: stated_dialect(path),
        start,
        start_modes,
        interpolation: stated(text),
        // The points under `CUTCOM/` stand at the radius of the cutter beside the walls of the part.
        cutcom_at_centre: true,
        work_offsets: Arc::new(WorkOffsets {
            only_mm: Some([0.0; 3]),
            named_mm: OFFSETS
                .iter()
                .filter_map(|name| WorkOffset::from_name(name))
                .map(|name| (name, [0.0; 3]))
                .collect(),
            ..WorkOffsets::default()
        }),
        radius_offsets: Arc::new(RadiusOffsets {
            by_register_mm: (1..=MOST_REGISTERS)
                .flat_map(|number| [RadiusRegister::D(number), RadiusRegister::H(number)])
                .map(|register| (register, RADIUS_MM))
                .collect(),
        }),
        ..in_mm(&Setup::default())
    };
    let (mut followed, mut only_places) = (0, true);
    let mut in_the_way: BTreeMap<String, u64> = BTreeMap::new();
    let mut take = |told: &Interpreted| {
        match told {
            Interpreted::Motion(_) => followed += 1,
            Interpreted::LeftAlone { reason, .. } => {
                only_places &= matches!(reason, Unfollowable::Reference | Unfollowable::MachineCoordinates);
                *in_the_way.entry(reason.to_string()).or_default() += 1;
            }
        }
        Ok(())
    };
    let stop = || ControlFlow::Continue(());
    let found = interpret_program(&machine, &program, &WithNeighbours::of(path, text), &mut take, &stop);
    let reach = match &found {
        Err(_) => Reach::Refused,
        Ok(_) if followed == 0 && in_the_way.is_empty() => Reach::Still,
        Ok(_) if in_the_way.is_empty() => Reach::Whole,
        Ok(_) if followed > 0 && only_places => Reach::ButForPlaces,
        Ok(_) if followed > 0 => Reach::InPart,
        Ok(_) => Reach::LeftUnchanged,
    };
    if let Err(fault) = found {
        (followed, in_the_way) = (0, BTreeMap::from([(fault.to_string(), 0)]));
    }
    Measured { name, reach, followed, in_the_way }
}

fn measured(folder: &Path) -> Vec<(&'static str, Vec<Measured>)> {
    let of_folder = |name: &'static str| {
        let below = folder.join(name);
        let files = every_file(&below).into_iter().filter(|path| is_program(path));
        let measured = files.map(|path| {
            let inside = path.strip_prefix(&below).unwrap().to_str().unwrap().to_owned();
            measure(inside, &path, &std::fs::read(&path).unwrap())
        });
        (name, measured.collect())
    };
    FOLDERS.into_iter().map(|(name, _)| of_folder(name)).collect()
}

/// The tables as they are in the page.
fn page(measured: &[(&'static str, Vec<Measured>)]) -> String {
    let mut page = format!("{BEGIN}\n\n");
    page.push_str(
        "| folder | programs | whole | all except places of the machine | in part | left unchanged | refused | no motion |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    let count = |programs: &[Measured], reach: Reach| {
        programs.iter().filter(|program| program.reach == reach).count()
    };
    let mut totals = [0; 6];
    for (name, programs) in measured {
        let counts = REACHES.map(|reach| count(programs, reach));
        let what = FOLDERS.iter().find(|(folder, _)| folder == name).unwrap().1;
        let cells: Vec<String> = counts.iter().map(usize::to_string).collect();
        writeln!(page, "| `{name}`: {what} | {} | {} |", programs.len(), cells.join(" | ")).unwrap();
        for (total, count) in totals.iter_mut().zip(counts) {
            *total += count;
        }
    }
    let cells: Vec<String> = totals.iter().map(usize::to_string).collect();
    writeln!(page, "| all | {} | {} |", totals.iter().sum::<usize>(), cells.join(" | ")).unwrap();
    page.push_str("\n| program | motions followed | motions left unchanged, and why |\n|---|---|---|\n");
    for (folder, programs) in measured {
        for program in programs.iter().filter(|program| !program.in_the_way.is_empty()) {
            let mut reasons: Vec<_> = program.in_the_way.iter().collect();
            reasons.sort_by_key(|(reason, count)| (std::cmp::Reverse(**count), reason.as_str()));
            let reasons: Vec<String> = reasons
                .into_iter()
                .map(|(reason, count)| match count {
                    0 => format!("refused: {}", reason.replace('|', "/")),
                    count => format!("{count}: {reason}"),
                })
                .collect();
            writeln!(page, "| `{folder}/{}` | {} | {} |", program.name, program.followed, reasons.join("; "))
                .unwrap();
        }
    }
    write!(page, "\n{END}").unwrap();
    page
}

const BEGIN: &str = "<!-- written by tests/corpus/reach.rs -->";
const END: &str = "<!-- end of what it writes -->";

#[test]
fn the_tables_of_how_far_programs_are_followed_are_those_of_the_page() {
    let Some(folder) = shared_file("programs") else { return };
    let measured = measured(&folder);
    let found = page(&measured);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/evidence.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let from = text.find(BEGIN).expect("the page has a place for the tables");
    let to = text.find(END).expect("the place ends") + END.len();
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, [&text[..from], &found, &text[to..]].concat()).unwrap();
        return;
    }
    assert!(text[from..to] == found, "docs/evidence.md has other tables; BLESS=1 writes them:\n{found}");
}
