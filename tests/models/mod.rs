//! Truth problems: parts whose surface, normals and machines are known exactly, with the programs that cut them.
//! Included by the test binaries and benches that need them.
#![expect(dead_code, unreachable_pub, reason = "each binary uses its own part")]

pub mod axes_witness;
pub mod displaced;
pub mod finishing;
pub mod hostile_facets;
pub mod pole_passes;
pub mod set_ups;
pub mod surface_passes;
pub mod tessellation;
pub mod told;
pub mod witness;
