//! The closed profile of a blade: the envelope of circles along a camber line.
//!
//! The camber line is an arc of length L and curvature κ. The circle at the distance s has the radius ρ(s), a
//! parabola with given values at both ends and a given maximum between. With T, N along and across the camber line,
//! the envelope is `C + ρ n`, `n = −ρ′ T ± √(1 − ρ′²) N`, and n is its exact normal. The circles at the ends close
//! it through the same normals, so that the whole loop is G1.

use crate::geometry::{Vec3, trig};

/// A closed profile in the plane z = 0, counter-clockwise, with the part inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BladeProfile {
    length_mm: f64,
    camber_per_mm: f64,
    /// ρ, ρ′ at s = 0, and ρ″.
    radius: [f64; 3],
    /// Angles of the normals against the camber line at both ends [rad].
    end_angles_rad: [f64; 2],
    /// Share of the parameter for each piece: upper side, leading edge, lower side, trailing edge.
    shares: [f64; 4],
}

/// A point of the profile with its derivatives by the parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct ProfilePoint {
    /// The point [mm].
    pub(super) point_mm: Vec3,
    /// First derivative [mm].
    pub(super) by_u: Vec3,
    /// Second derivative [mm].
    pub(super) by_uu: Vec3,
}

impl BladeProfile {
    /// The profile. [`Self::steepest`] tells whether it is valid.
    pub(super) fn new(length_mm: f64, camber_rad: f64, half_thickness_mm: f64, edges_mm: [f64; 2]) -> Self {
        let [first, last] = edges_mm;
        // ρ = (1−t)ρ₀ + tρ₁ + 4bt(1−t) has its maximum ρm for b = (√(ρm−ρ₀) + √(ρm−ρ₁))²/4, t = s/L
        let root = (half_thickness_mm - first).max(0.0).sqrt() + (half_thickness_mm - last).max(0.0).sqrt();
        let rise = root * root;
        let slope = (last - first + rise) / length_mm;
        let bend = -2.0 * rise / (length_mm * length_mm);
        let mut profile = Self {
            length_mm,
            camber_per_mm: camber_rad / length_mm,
            radius: [first, slope, bend],
            end_angles_rad: [0.0; 2],
            shares: [0.0; 4],
        };
        profile.end_angles_rad = [0.0, length_mm].map(|s| {
            let slope = profile.radius_at(s)[1];
            trig::atan2((1.0 - slope * slope).max(0.0).sqrt(), -slope)
        });
        let [start, end] = profile.end_angles_rad;
        let arcs = [first * 2.0 * (std::f64::consts::PI - start), last * 2.0 * end];
        let total = 2.0 * length_mm + arcs[0] + arcs[1];
        profile.shares = [length_mm / total, arcs[0] / total, length_mm / total, arcs[1] / total];
        profile
    }

    /// Largest |ρ′|. A valid profile needs it below 1.
    pub(super) fn steepest(&self) -> f64 {
        self.radius_at(0.0)[1].abs().max(self.radius_at(self.length_mm)[1].abs())
    }

    /// The parameters at which the pieces meet. The loop closes at 1.
    #[cfg(test)]
    pub(super) fn joints(&self) -> [f64; 3] {
        let [a, b, c, _] = self.shares;
        [a, a + b, a + b + c]
    }

    /// ρ, ρ′ and ρ″ at the distance s.
    fn radius_at(&self, s: f64) -> [f64; 3] {
        let [radius, slope, bend] = self.radius;
        [radius + s * (slope + 0.5 * bend * s), slope + bend * s, bend]
    }

    /// The camber line at the distance s: its point and its angle.
    fn camber_at(&self, s: f64) -> (Vec3, f64) {
        let way = s - 0.5 * self.length_mm;
        let angle = self.camber_per_mm * way;
        if angle == 0.0 {
            return (Vec3::new(way, 0.0, 0.0), 0.0);
        }
        let (sin, _) = trig::sin_cos(angle);
        let (half, _) = trig::sin_cos(0.5 * angle);
        (Vec3::new(sin, 2.0 * half * half, 0.0) / self.camber_per_mm, angle)
    }

    /// The profile at the parameter u in [0, 1].
    pub(super) fn at(&self, u: f64) -> ProfilePoint {
        let [upper, leading, lower, trailing] = self.shares;
        let (length, [start, end]) = (self.length_mm, self.end_angles_rad);
        if u < upper {
            self.side(1.0, length * (1.0 - u / upper), -length / upper)
        } else if u < upper + leading {
            let turn = 2.0 * (std::f64::consts::PI - start);
            self.edge(0.0, start + turn * (u - upper) / leading, turn / leading)
        } else if u < upper + leading + lower {
            self.side(-1.0, length * (u - upper - leading) / lower, length / lower)
        } else {
            let part = (u - upper - leading - lower) / trailing;
            self.edge(length, -end + 2.0 * end * part, 2.0 * end / trailing)
        }
    }

    /// A side (+1 left of the camber line, −1 right of it) at the distance s, which grows by `rate` with the
    /// parameter.
    fn side(&self, side: f64, s: f64, rate: f64) -> ProfilePoint {
        let [radius, slope, bend] = self.radius_at(s);
        let (centre, angle) = self.camber_at(s);
        // θ between camber line and normal: cos θ = −ρ′.
        let (cos, sin) = (-slope, ((1.0 - slope) * (1.0 + slope)).sqrt());
        let (turn, turn_rate) = (bend / sin, -bend * cos * (bend / sin) / (sin * sin));
        let (tangent_sin, tangent_cos) = trig::sin_cos(angle);
        let tangent = Vec3::new(tangent_cos, tangent_sin, 0.0);
        let normal = tangent * cos + quarter(tangent) * (side * sin);
        let along = quarter(normal);
        // ω: turn rate of the normal. The distance along the side is −side · speed · along.
        let omega = self.camber_per_mm + side * turn;
        let speed = sin - side * radius * omega;
        let speed_rate = cos * turn - side * slope * omega - radius * turn_rate;
        ProfilePoint {
            point_mm: centre + normal * radius,
            by_u: along * (-side * speed * rate),
            by_uu: (along * speed_rate - normal * (speed * omega)) * (-side * rate * rate),
        }
    }

    /// The circle about the camber line's end, at an angle from that line, which grows by `rate`.
    fn edge(&self, s: f64, angle: f64, rate: f64) -> ProfilePoint {
        let radius = self.radius_at(s)[0];
        let (centre, camber) = self.camber_at(s);
        let (sin, cos) = trig::sin_cos(camber + angle);
        let normal = Vec3::new(cos, sin, 0.0);
        ProfilePoint {
            point_mm: centre + normal * radius,
            by_u: quarter(normal) * (radius * rate),
            by_uu: normal * (-radius * rate * rate),
        }
    }
}

/// A vector turned by a quarter about +Z.
pub(super) fn quarter(v: Vec3) -> Vec3 {
    Vec3::new(-v.y, v.x, 0.0)
}
