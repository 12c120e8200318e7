#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| flb_tests::targets::texture(bytes));
