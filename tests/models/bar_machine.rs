//! A second machine for calibrations: every frame displaced as a body, chained as 4 × 4 matrices from bed to table and
//! from ram to tool, rotations as unit quaternions. It shares no formula and no code with the model under test, only
//! the definition of a location error (a small displacement of the axis' own frame about its reference point).

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use trunnion::machine::{Machine, Side};

/// Six components of each axis: mm, mm, mm, rad, rad, rad.
pub(crate) type AxisErrors = [[f64; 6]; 2];

/// One axis.
#[derive(Debug, Clone)]
struct Axis {
    head: bool,
    direction: Vector3<f64>,
    point: Vector3<f64>,
}

/// The machine.
#[derive(Debug, Clone)]
pub(crate) struct BarMachine {
    axes: Vec<Axis>,
    tool_length_mm: f64,
}

fn about(axis: &Axis, angle: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(axis.direction * angle);
    Isometry3::from_parts(Translation3::from(axis.point), UnitQuaternion::identity())
        * turn
        * Translation3::from(-axis.point)
}

fn displaced(axis: &Axis, error: &[f64; 6]) -> Isometry3<f64> {
    let [x, y, z, a, b, c] = *error;
    Translation3::new(x, y, z)
        * Translation3::from(axis.point)
        * UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c))
        * Translation3::from(-axis.point)
}

impl BarMachine {
    /// The nominal geometry of a machine.
    pub(crate) fn new(machine: &Machine, tool_length_mm: f64) -> Self {
        let axes = machine
            .rotary_axes()
            .iter()
            .map(|axis| {
                let head = axis.side == Side::Head;
                let up = if head { tool_length_mm } else { 0.0 };
                Axis { head, direction: axis.direction, point: axis.point_mm + Vector3::z() * up }
            })
            .collect();
        Self { axes, tool_length_mm }
    }

    /// The body at the end of one side's chain at these angles, relative to itself at zero.
    fn moved(&self, head: bool, errors: &AxisErrors, angles: [f64; 2]) -> Isometry3<f64> {
        let chain = |angles: [f64; 2]| {
            let mut body = Isometry3::identity();
            for ((axis, error), angle) in self.axes.iter().zip(errors).zip(angles) {
                if axis.head == head {
                    // A positive word moves the tool relative to the workpiece: a table turns the other way.
                    let sense = if head { 1.0 } else { -1.0 };
                    body = body * displaced(axis, error) * about(axis, sense * angle);
                }
            }
            body
        };
        chain(angles) * chain([0.0; 2]).inverse()
    }

    /// Where a point of the table stands at these angles [mm], seen from where it stands at zero.
    pub(crate) fn on_table(&self, errors: &AxisErrors, angles: [f64; 2], point: [f64; 3]) -> Vector3<f64> {
        (self.moved(false, errors, angles) * Point3::from(point)).coords
    }

    /// Where the last table axis stands; its origin without one.
    fn center(&self) -> Vector3<f64> {
        self.axes.iter().rev().find(|axis| !axis.head).map_or_else(Vector3::zeros, |axis| axis.point)
    }

    /// What a bar reads [mm]: ball programmed at `ball` from the centre, the real ball offset by `setup`, the bar
    /// pointing along `bar` from the table's ball at zero, axis `turned` at `angle`.
    #[expect(clippy::too_many_arguments, reason = "one number each of a set-up")]
    pub(crate) fn reading(
        &self,
        errors: &AxisErrors,
        setup: [f64; 2],
        length: f64,
        bar: Vector3<f64>,
        ball: Vector3<f64>,
        turned: usize,
        angle: f64,
    ) -> f64 {
        assert!(self.tool_length_mm >= 0.0);
        let none = [[0.0; 6]; 2];
        let offset = Point3::new(setup[0], setup[1], 0.0);
        let programmed = Point3::from(self.center() + ball);
        let distance = |angles: [f64; 2]| {
            // Slides: nominal table carries the programmed point, nominal head swings the tip away.
            let swing = self.moved(true, &none, angles) * Point3::origin();
            let slides = self.moved(false, &none, angles) * programmed - swing;
            let spindle_ball = slides + (self.moved(true, errors, angles) * offset).coords;
            let table_ball_at_zero = Point3::from(programmed.coords + offset.coords - bar * length);
            let table_ball = self.moved(false, errors, angles) * table_ball_at_zero;
            (Point3::from(spindle_ball) - table_ball).norm()
        };
        let mut angles = [0.0; 2];
        angles[turned] = angle;
        distance(angles) - distance([0.0; 2])
    }
}

/// Numbers that look random and are the same on every machine (splitmix64, and the polar method for normal ones).
#[derive(Debug, Clone)]
pub(crate) struct Seeded(pub(crate) u64);

impl Seeded {
    /// Uniform in (−1, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^= mixed >> 31;
        (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Standard normal.
    pub(crate) fn normal(&mut self) -> f64 {
        loop {
            let (u, v) = (self.uniform(), self.uniform());
            let square = u * u + v * v;
            if square > 0.0 && square < 1.0 {
                return u * (-2.0 * square.ln() / square).sqrt();
            }
        }
    }
}
