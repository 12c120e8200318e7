//! The inner loops of reading: a component's fields, alone or times their weights, eight at once. One clear version in
//! plain Rust, and one in AVX2, which takes the same steps in the same order and has the same bits.

use super::classes::{FieldGroup, GROUP_BYTES, LANES};
use super::transform::{EDGE, TEXELS};

/// Weights of a block's coefficients, by place: a product of one of sixteen and one of four.
pub(super) struct Weights {
    /// `[digit 2][digit 1]`
    high: [f32; TEXELS / EDGE],
    /// `[digit 0]`, twice.
    low: [f32; LANES],
}

impl Weights {
    /// From those of the digits of places.
    #[inline(always)]
    pub(super) fn new([low, middle, high]: [&[f32; EDGE]; 3]) -> Weights {
        Weights {
            high: std::array::from_fn(|i| high[i / EDGE] * middle[i % EDGE]),
            low: std::array::from_fn(|i| low[i % EDGE]),
        }
    }

    /// Of a place, below 64.
    #[inline(always)]
    pub(super) fn at(&self, place: usize) -> f32 {
        self.high[place / EDGE] * self.low[place % EDGE]
    }
}

/// A way to read fields.
pub(super) trait Lanes: Copy {
    /// Coefficients of a group, in half steps. `bytes` begins with the component's fields.
    fn values(self, group: &FieldGroup, bytes: &[u8]) -> [i32; LANES];

    /// Sum of the coefficients of a class times their weights, in half steps. `bytes` begins with the component's
    /// fields.
    fn sum(self, groups: &[FieldGroup], bytes: &[u8], weights: &Weights) -> f32;
}

/// What is done with fields.
pub(super) trait Job {
    type Output;

    /// Does it one way; to be inlined into code for that way.
    fn call<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Does it the fastest way that the machine has.
#[inline]
pub(super) fn run<J: Job>(job: J) -> J::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = Avx2::get() {
        return simd.run(job);
    }
    job.call(Scalar)
}

/// In plain Rust.
#[derive(Clone, Copy)]
pub(super) struct Scalar;

impl Lanes for Scalar {
    #[inline(always)]
    fn values(self, group: &FieldGroup, bytes: &[u8]) -> [i32; LANES] {
        let window = window(group, bytes);
        std::array::from_fn(|lane| group.value(lane, window))
    }

    #[inline(always)]
    fn sum(self, groups: &[FieldGroup], bytes: &[u8], weights: &Weights) -> f32 {
        let mut sums = [0.0f32; LANES];
        for group in groups {
            let values = self.values(group, bytes);
            for (lane, sum) in sums.iter_mut().enumerate() {
                *sum += values[lane] as f32 * weights.at(group.place(lane));
            }
        }
        total(sums)
    }
}

#[inline(always)]
fn window<'a>(group: &FieldGroup, bytes: &'a [u8]) -> &'a [u8; GROUP_BYTES] {
    bytes[group.first_byte()..].first_chunk().expect("a window lies behind the last field")
}

#[inline(always)]
fn total(s: [f32; LANES]) -> f32 {
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{__m128i, __m256, __m256i};

    use pulp::x86::V3;

    use super::{FieldGroup, Job, LANES, Lanes, Weights, total, window};

    /// Where the machine has AVX2.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2(V3);

    impl Avx2 {
        /// If the machine has it.
        #[inline]
        pub(crate) fn get() -> Option<Avx2> {
            V3::try_new().map(Avx2)
        }

        /// A job, with everything inlined into code for AVX2.
        #[inline]
        pub(crate) fn run<J: Job>(self, job: J) -> J::Output {
            self.0.vectorize(Run { lanes: self, job })
        }

        #[inline(always)]
        fn fields(self, group: &FieldGroup, bytes: &[u8]) -> __m256i {
            let (simd, avx) = (self.0.avx2, self.0.avx);
            let window: __m128i = pulp::cast(*window(group, bytes));
            let mask: __m256i = pulp::cast(group.mask);
            let words =
                simd._mm256_shuffle_epi8(simd._mm256_broadcastsi128_si256(window), pulp::cast(group.bytes));
            let shift = simd._mm256_and_si256(
                simd._mm256_srli_epi32::<8>(pulp::cast(group.code)),
                avx._mm256_set1_epi32(7),
            );
            let fields = simd._mm256_and_si256(simd._mm256_srlv_epi32(words, shift), mask);
            simd._mm256_sub_epi32(simd._mm256_add_epi32(fields, fields), mask)
        }
    }

    struct Run<J> {
        lanes: Avx2,
        job: J,
    }

    impl<J: Job> pulp::NullaryFnOnce for Run<J> {
        type Output = J::Output;

        #[inline(always)]
        fn call(self) -> J::Output {
            self.job.call(self.lanes)
        }
    }

    impl Lanes for Avx2 {
        #[inline(always)]
        fn values(self, group: &FieldGroup, bytes: &[u8]) -> [i32; LANES] {
            pulp::cast(self.fields(group, bytes))
        }

        #[inline(always)]
        fn sum(self, groups: &[FieldGroup], bytes: &[u8], weights: &Weights) -> f32 {
            let (simd, avx) = (self.0.avx2, self.0.avx);
            let [high_first, high_last]: [__m256; 2] = pulp::cast(weights.high);
            let low: __m256 = pulp::cast(weights.low);
            let mut sums = avx._mm256_setzero_ps();
            for group in groups {
                let values = self.fields(group, bytes);
                let code: __m256i = pulp::cast(group.code);
                let i = simd._mm256_srli_epi32::<2>(code);
                let high = avx._mm256_blendv_ps(
                    simd._mm256_permutevar8x32_ps(high_first, i),
                    simd._mm256_permutevar8x32_ps(high_last, i),
                    pulp::cast(code),
                );
                let weight = avx._mm256_mul_ps(high, simd._mm256_permutevar8x32_ps(low, code));
                sums = avx._mm256_add_ps(sums, avx._mm256_mul_ps(avx._mm256_cvtepi32_ps(values), weight));
            }
            total(pulp::cast(sums))
        }
    }
}
