#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| trunnion_fuzz::checks::reader(trunnion_fuzz::program::Dialect::Okuma, data));
