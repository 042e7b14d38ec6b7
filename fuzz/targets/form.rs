#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| trunnion_fuzz::forms::form(data));
