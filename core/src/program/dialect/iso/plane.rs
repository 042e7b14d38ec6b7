//! `G68.2 X Y Z I J K`: a plane by its zero and three Euler angles.

use crate::program::plane::{PlaneDirections, PlaneStatement, PlaneTurning};
use crate::program::{Address, Batch, Block, Code, WordForm};

/// G68.2, and G90, which is all that may stand beside it.
const PLANE: Code = Code::G(682);
const ABSOLUTE: Code = Code::G(900);

/// The plane of a block with G68.2, the words I J K and all or none of X Y Z. `P0` says the same. With another P, and
/// with Q and R, controls differ.
///
/// The directions are turned about Z by I, then about the turned X by J, then about the turned Z by K. G53.1 turns the
/// rotary axes.
pub(super) fn read(batch: &Batch, block: &Block) -> Option<PlaneStatement> {
    let (mut zero, mut angles) = ([None; 3], [None; 3]);
    let mut is_plane = false;
    for word in batch.words(block) {
        let slot = match word.address {
            Address::N => continue,
            Address::G => {
                let code = word.code()?;
                is_plane |= code == PLANE;
                if code != PLANE && code != ABSOLUTE {
                    return None;
                }
                continue;
            }
            Address::P if word.is_known() && word.value == 0.0 => continue,
            Address::X => &mut zero[0],
            Address::Y => &mut zero[1],
            Address::Z => &mut zero[2],
            Address::I => &mut angles[0],
            Address::J => &mut angles[1],
            Address::K => &mut angles[2],
            _ => return None,
        };
        let is_value = matches!(word.form, WordForm::Number | WordForm::Evaluated) && word.is_known();
        if !is_value || slot.replace(word.value).is_some() {
            return None;
        }
    }
    let zero = match zero {
        [None, None, None] => [0.0; 3],
        [x, y, z] => [x?, y?, z?],
    };
    let [first, second, third] = angles;
    is_plane.then_some(PlaneStatement {
        zero,
        directions: PlaneDirections::Turns([(2, first?), (0, second?), (2, third?)]),
        shift: [0.0; 3],
        counts_in_unit: true,
        replaces: false,
        turning: PlaneTurning::ByCode,
        side: None,
        free_axis: None,
    })
}
