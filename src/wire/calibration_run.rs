//! A posted calibration run in the core's terms, and the location of every fault in it.

use super::{
    BallBarTestDoc, BarDirectionDoc, CalibrationKind, CalibrationRequest, Fault, FaultList, SetupErrorDoc,
    SpindleBar,
};
use crate::calibration::rotary_sphere::{AxisCenters, Center, SphereFault, SphereRunFault};
use crate::calibration::{
    BallBarRun, BallBarTest, BarDirection, InputUncertainties, Observed, Reading, RunFault, SetupError,
    SpindleStep,
};
use crate::geometry::Vec3;
use crate::machine::Machine;
use crate::units::{Angle, Length};

/// Temperatures that are accepted (°C).
const TEMPERATURE_RANGE_C: [f64; 2] = [-50.0, 100.0];
/// Longest name of a person or an instrument, and longest note (characters).
const MAX_NAME: usize = 200;
const MAX_NOTE: usize = 2000;

/// Largest standard uncertainties of the set-up that are accepted: larger ones are mistakes of the unit.
const MAX_SETUP_UNCERTAINTY_UM: f64 = 10_000.0;
const MAX_BALL_UNCERTAINTY_MM: f64 = 100.0;
const MAX_SHARE_OF_BAR: f64 = 0.5;

impl BarDirectionDoc {
    /// The direction in the core's terms.
    #[must_use]
    pub const fn to_core(self) -> BarDirection {
        match self {
            Self::Radial => BarDirection::Radial,
            Self::Tangential => BarDirection::Tangential,
            Self::Axial => BarDirection::Axial,
        }
    }

    /// The word in documents.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        self.to_core().as_str()
    }
}

impl CalibrationRequest {
    /// Checks the members that every kind has (names, note, temperature), and that no member belongs to
    /// another kind.
    pub fn check(&self, faults: &mut FaultList) {
        let texts = [
            ("/instrument", &self.instrument, MAX_NAME),
            ("/instrument_serial_number", &self.instrument_serial_number, MAX_NAME),
            ("/instrument_certificate", &self.instrument_certificate, MAX_NAME),
            ("/operator", &self.operator, MAX_NAME),
            ("/note", &self.note, MAX_NOTE),
        ];
        for (pointer, text, max) in texts {
            let length = text.as_ref().map_or(0, |text| text.chars().count());
            if length > max {
                faults.push(|| Fault::new(pointer, format!("{length} characters are more than {max}")));
            }
            let is_note = pointer == "/note";
            let no_character = |letter: char| letter.is_control() && !(is_note && "\n\r\t".contains(letter));
            if let Some(letter) =
                text.as_deref().and_then(|text| text.chars().find(|letter| no_character(*letter)))
            {
                let detail = format!("{letter:?} is a control character; remove it");
                faults.push(|| Fault::new(pointer, detail));
            }
        }
        if let Some(temperature_c) = self.temperature_c {
            let [min, max] = TEMPERATURE_RANGE_C;
            faults.check_range(|| "/temperature_c".to_owned(), temperature_c, min, max);
        }
        let ballbar = [
            ("instrument_uncertainty_um", self.instrument_uncertainty_um.is_some()),
            ("setup_uncertainty_um", self.setup_uncertainty_um.is_some()),
            ("ball_uncertainty_mm", self.ball_uncertainty_mm.is_some()),
            ("bar_length_uncertainty_mm", self.bar_length_uncertainty_mm.is_some()),
            ("bar_length_mm", self.bar_length_mm.is_some()),
            ("offset_per_test", self.offset_per_test.is_some()),
            ("setup_error_um", self.setup_error_um.is_some()),
            ("tests", self.tests.is_some()),
        ];
        let spheres = [("axes", self.axes.is_some())];
        let foreign: &[(&str, bool)] = match self.kind {
            CalibrationKind::RtcpBallbar => &spheres,
            CalibrationKind::RotarySphere => &ballbar,
        };
        for (name, is_there) in foreign {
            if *is_there {
                let kind = self.kind.as_str();
                faults.push(|| {
                    Fault::new(format!("/{name}"), format!("a {kind} run has no {name}; remove this member"))
                });
            }
        }
    }

    /// Checks the stated uncertainties of the set-up of a ball bar.
    fn check_setup_uncertainties(&self, faults: &mut FaultList) {
        if let Some(um) = self.setup_uncertainty_um {
            faults.check_range(|| "/setup_uncertainty_um".to_owned(), um, 0.0, MAX_SETUP_UNCERTAINTY_UM);
            if self.setup_error_um.as_ref().is_some_and(|doc| doc.spindle_deg.is_some()) {
                let detail = "the spindle step measures the set-up error, and the scatter of the readings has its uncertainty; remove this member";
                faults.push(|| Fault::new("/setup_uncertainty_um", detail));
            }
        }
        if let Some(mm) = self.ball_uncertainty_mm {
            faults.check_range(|| "/ball_uncertainty_mm".to_owned(), mm, 0.0, MAX_BALL_UNCERTAINTY_MM);
        }
        if let (Some(mm), Some(length_mm)) = (self.bar_length_uncertainty_mm, self.bar_length_mm) {
            let max_mm = length_mm.max(0.0) * MAX_SHARE_OF_BAR;
            faults.check_range(|| "/bar_length_uncertainty_mm".to_owned(), mm, 0.0, max_mm);
        }
    }

    /// The stated uncertainties of the set-up in the core's terms.
    #[must_use]
    pub fn input_uncertainties(&self) -> InputUncertainties {
        InputUncertainties {
            setup_error_mm: self.setup_uncertainty_um.map(|um| Length::from_um(um).mm()),
            ball_mm: self.ball_uncertainty_mm,
            bar_length_mm: self.bar_length_uncertainty_mm,
        }
    }

    /// The run of a ball bar in the core's terms; `faults` gets every fault with its location.
    pub fn to_ballbar(&self, machine: &Machine, faults: &mut FaultList) -> Option<BallBarRun> {
        self.check_setup_uncertainties(faults);
        let missing = |name: &str| Fault::new(format!("/{name}"), format!("missing field `{name}`"));
        if self.bar_length_mm.is_none() {
            faults.push(|| missing("bar_length_mm"));
        }
        let Some(tests) = &self.tests else {
            faults.push(|| missing("tests"));
            return None;
        };
        // Checked before anything is built from the tests.
        if tests.len() > BallBarRun::MAX_TESTS {
            let fault = RunFault::TestCount { tests: tests.len(), max: BallBarRun::MAX_TESTS };
            faults.push(|| Fault::new("/tests", fault.to_string()));
            return None;
        }
        let weighted = tests.iter().filter(|test| test.reading_uncertainty_um.is_some()).count();
        if weighted > 0 && weighted < tests.len() {
            let detail = "reading_uncertainty_um is given for some tests only, but it sets their weights; give it for all tests or for none";
            faults.push(|| Fault::new("/tests", detail));
        }
        let core: Vec<Option<BallBarTest>> =
            tests.iter().enumerate().map(|(index, test)| test.to_core(index, machine, faults)).collect();
        let setup_error =
            self.setup_error_um.as_ref().map_or(Some(SetupError::Unknown), |doc| doc.to_core(faults));
        let run = BallBarRun {
            bar_length_mm: self.bar_length_mm.unwrap_or(BallBarRun::BAR_LENGTH_RANGE_MM[0]),
            offset_per_test: self.offset_per_test.unwrap_or(true),
            instrument_uncertainty_mm: self.instrument_uncertainty_um.map(|um| Length::from_um(um).mm()),
            setup_error: setup_error.clone().unwrap_or(SetupError::Unknown),
            // Only the tests that can be checked.
            tests: core.iter().flatten().cloned().collect(),
        };
        let places: Vec<usize> =
            core.iter().enumerate().filter(|(_, test)| test.is_some()).map(|(index, _)| index).collect();
        // If there were tests, the reason why none is left has already been reported.
        if (!places.is_empty() || tests.is_empty())
            && let Err(found) = run.check(machine)
        {
            for fault in &found {
                faults.push(|| located(fault, &places));
            }
        }
        (faults.is_empty() && core.len() == places.len() && setup_error.is_some()).then_some(run)
    }
}

impl SetupErrorDoc {
    fn to_core(&self, faults: &mut FaultList) -> Option<SetupError> {
        let mm = |um: f64| Length::from_um(um).mm();
        let known = self.e_xs.is_some() || self.e_ys.is_some();
        let spindle =
            self.spindle_deg.is_some() || self.bar_direction.is_some() || self.length_change_um.is_some();
        match (known, spindle) {
            (true, false) => {
                let (Some(x), Some(y)) = (self.e_xs, self.e_ys) else {
                    let name = if self.e_xs.is_none() { "e_xs" } else { "e_ys" };
                    let pointer = format!("/setup_error_um/{name}");
                    faults.push(|| Fault::new(pointer, format!("missing field `{name}`")));
                    return None;
                };
                Some(SetupError::Known([mm(x), mm(y)]))
            }
            (false, true) => {
                let (Some(angles), Some(bar), Some(changes)) =
                    (&self.spindle_deg, self.bar_direction, &self.length_change_um)
                else {
                    let detail = "a spindle step has spindle_deg, bar_direction and length_change_um";
                    faults.push(|| Fault::new("/setup_error_um", detail));
                    return None;
                };
                if angles.len() != changes.len() || angles.len() > MAX_SPINDLE_ANGLES {
                    let (angles, changes) = (angles.len(), changes.len());
                    faults.push(|| {
                        Fault::new(
                            "/setup_error_um",
                            format!(
                                "{angles} spindle angles and {changes} readings: give as many of each, at most {MAX_SPINDLE_ANGLES}"
                            ),
                        )
                    });
                    return None;
                }
                let readings = angles
                    .iter()
                    .zip(changes)
                    .map(|(angle, change)| Reading {
                        angle_rad: Angle::from_deg(*angle).rad(),
                        length_change_mm: mm(*change),
                    })
                    .collect();
                let bar = match bar {
                    SpindleBar::X => Vec3::x(),
                    SpindleBar::Y => Vec3::y(),
                };
                Some(SetupError::Spindle(SpindleStep { bar, readings }))
            }
            (true, true) | (false, false) => {
                let detail =
                    "either e_xs and e_ys, or spindle_deg, bar_direction and length_change_um, or null";
                faults.push(|| Fault::new("/setup_error_um", detail));
                None
            }
        }
    }
}

/// Most angles of a spindle step.
const MAX_SPINDLE_ANGLES: usize = 1000;

impl BallBarTestDoc {
    fn to_core(&self, index: usize, machine: &Machine, faults: &mut FaultList) -> Option<BallBarTest> {
        let Some(axis) = axis_index(machine, &self.rotary_axis) else {
            let pointer = format!("/tests/{index}/rotary_axis");
            faults.push(|| Fault::new(pointer, no_such_axis(machine, &self.rotary_axis)));
            return None;
        };
        let turned = &machine.rotary_axes()[axis];
        let observed = match (&self.readings, self.eccentricity_um) {
            (Some(readings), None) => Observed::Readings(
                readings
                    .iter()
                    .map(|reading| Reading {
                        angle_rad: turned.angle_rad(reading.angle_deg),
                        length_change_mm: Length::from_um(reading.length_change_um).mm(),
                    })
                    .collect(),
            ),
            (None, Some(pair)) => Observed::Eccentricity(pair.0.map(|um| Length::from_um(um).mm())),
            _ => {
                let detail = "a test has either readings or eccentricity_um";
                faults.push(|| Fault::new(format!("/tests/{index}"), detail));
                return None;
            }
        };
        Some(BallBarTest {
            axis,
            bar: self.bar_direction.to_core(),
            ball_mm: Vec3::from(self.ball_mm.0),
            tool_length_mm: self.tool_length_mm.unwrap_or(0.0),
            reading_uncertainty: self.reading_uncertainty_um.unwrap_or(1.0),
            observed,
        })
    }
}

impl CalibrationRequest {
    /// The probed spheres in the core's terms; `faults` gets every fault with its location.
    pub fn to_spheres(&self, machine: &Machine, faults: &mut FaultList) -> Option<Vec<AxisCenters>> {
        let Some(axes) = &self.axes else {
            faults.push(|| Fault::new("/axes", "missing field `axes`"));
            return None;
        };
        let mut run = Vec::new();
        for (entry, probed) in axes.iter().enumerate().take(MAX_SPHERE_AXES) {
            let Some(axis) = axis_index(machine, &probed.rotary_axis) else {
                let pointer = format!("/axes/{entry}/rotary_axis");
                faults.push(|| Fault::new(pointer, no_such_axis(machine, &probed.rotary_axis)));
                continue;
            };
            let turned = &machine.rotary_axes()[axis];
            let centers = probed
                .centres
                .iter()
                .map(|centre| Center {
                    ball: centre.sphere as usize,
                    angle_rad: centre.angle_deg.map(|word_deg| turned.angle_rad(word_deg)),
                    center_mm: Vec3::from(centre.centre_mm.0),
                })
                .collect();
            run.push(AxisCenters { axis, centers });
        }
        (run.len() == axes.len().min(MAX_SPHERE_AXES)).then_some(run)
    }
}

/// How many axes of a sphere run are checked: one more than any machine has, so that an extra axis is
/// noticed.
const MAX_SPHERE_AXES: usize = 3;

fn axis_index(machine: &Machine, letter: &str) -> Option<usize> {
    machine.rotary_axes().iter().position(|axis| letter == axis.letter.as_char().to_string())
}

fn no_such_axis(machine: &Machine, letter: &str) -> String {
    let [first, second] = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
    format!("the machine's rotary axes are {first} and {second}, not {letter:?}")
}

/// A fault of probed spheres, with its location in the document.
#[must_use]
pub fn sphere_fault(fault: &SphereRunFault) -> Fault {
    let pointer = match *fault {
        SphereRunFault::AxisCount { .. } | SphereRunFault::Location { .. } => "/axes".to_owned(),
        SphereRunFault::NoSuchAxis { entry, .. }
        | SphereRunFault::Repeated { entry }
        | SphereRunFault::OnHead { entry } => format!("/axes/{entry}/rotary_axis"),
        SphereRunFault::SomeAngles { entry, .. } | SphereRunFault::BallsWithoutAngles { entry, .. } => {
            format!("/axes/{entry}/centres")
        }
        SphereRunFault::Fit { entry, fault: SphereFault::Coordinate { reading, component, .. } } => {
            format!("/axes/{entry}/centres/{reading}/centre_mm/{component}")
        }
        SphereRunFault::Fit { entry, fault: SphereFault::Angle { reading, .. } } => {
            format!("/axes/{entry}/centres/{reading}/angle_deg")
        }
        SphereRunFault::Fit { entry, .. } => format!("/axes/{entry}/centres"),
    };
    Fault::new(pointer, fault.to_string())
}

/// A fault of the core, with its location in the document; `places` are the indices of the tests that the
/// core saw.
fn located(fault: &RunFault, places: &[usize]) -> Fault {
    let of_test =
        |test: usize, rest: String| format!("/tests/{}{rest}", places.get(test).copied().unwrap_or(test));
    let of_reading = |test: Option<usize>, reading: usize, name: &str| match test {
        Some(test) => of_test(test, format!("/readings/{reading}/{name}")),
        None if name == "angle_deg" => format!("/setup_error_um/spindle_deg/{reading}"),
        None => format!("/setup_error_um/{name}/{reading}"),
    };
    let pointer = match *fault {
        RunFault::BarLength { .. } => "/bar_length_mm".to_owned(),
        RunFault::InstrumentUncertainty { .. } => "/instrument_uncertainty_um".to_owned(),
        RunFault::SetupError { component, .. } => {
            format!("/setup_error_um/{}", if component == 0 { "e_xs" } else { "e_ys" })
        }
        RunFault::TestCount { .. }
        | RunFault::TooManyReadings { .. }
        | RunFault::NothingDetermined
        | RunFault::NoFit { .. } => "/tests".to_owned(),
        RunFault::ToolLength { test, .. } => of_test(test, "/tool_length_mm".to_owned()),
        RunFault::NoSuchAxis { test, .. } => of_test(test, "/rotary_axis".to_owned()),
        RunFault::Ball { test, component, .. } => of_test(test, format!("/ball_mm/{component}")),
        RunFault::ReadingUncertainty { test, .. } => of_test(test, "/reading_uncertainty_um".to_owned()),
        RunFault::Eccentricity { test, component, .. } => {
            of_test(test, format!("/eccentricity_um/{component}"))
        }
        RunFault::Angle { test, reading, .. } => of_reading(test, reading, "angle_deg"),
        RunFault::LengthChange { test, reading, .. } => of_reading(test, reading, "length_change_um"),
        RunFault::TooFewAngles { test: Some(test), .. } => of_test(test, "/readings".to_owned()),
        RunFault::TooFewAngles { test: None, .. } => "/setup_error_um/spindle_deg".to_owned(),
    };
    Fault::new(pointer, fault.to_string())
}

/// A fault of the fit.
#[must_use]
pub fn fit_fault(fault: &RunFault) -> Fault {
    located(fault, &[])
}
