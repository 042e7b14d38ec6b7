//! Tests over real programs; they run where `TRUNNION_SHARED` names the folder that holds them.

mod program;
