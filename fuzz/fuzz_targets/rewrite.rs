#![no_main]

libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    flb_fuzz::mutate_container(data, size, max_size, seed)
});
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| flb_tests::targets::rewrite(bytes));
