//! Coded bases to payloads: heads, averages, and pages of detail.

use flb_format::blocks::classes::bits;
use flb_format::blocks::{Averages, Classes, CodedBlock, Coding, Head, MAX_HALVINGS, coarse, detail};
use rayon::prelude::*;

use super::pass::{Coded, Pass, Quality, Try};
use super::ready::Ready;
use super::{BasePayloads, DetailPage, Missed, RateSettings, SpeciesPayloads};
use crate::priority;

/// The payloads of all bases.
pub(super) fn payloads(
    pass: &Pass,
    coding: Coding,
    coded: &[(Vec<Coded>, Quality)],
    missed: Vec<Missed>,
    settings: &RateSettings,
) -> SpeciesPayloads {
    let bases = coded.par_iter().flat_map_iter(|(coded, quality)| {
        coded
            .iter()
            .zip(&quality.of_bases)
            .map(|(coded, rms)| base_payloads(pass, &coding, coded, [*rms, quality.dark], settings))
    });
    SpeciesPayloads {
        missed,
        map: pass.geometry.map.to_bytes(),
        bases: bases.collect(),
        classes: match &coding {
            Coding::Classed(classes) => Some(classes.to_bytes()),
            Coding::Haar => None,
        },
    }
}

fn base_payloads(
    pass: &Pass,
    coding: &Coding,
    coded: &Coded,
    [rms, dark]: [f64; 2],
    settings: &RateSettings,
) -> BasePayloads {
    let Try { base, step, components, thresholds } = coded.tried;
    let ready: &Ready = &pass.ready[base];
    let head = Head {
        bands: ready.field.bands,
        axes: ready.axes,
        // A texel of 1 is a sixteenth of a step, and a step of row 0 along each axis is 1/216.
        unit: step * ready.light.peak / (216.0 * (2 << MAX_HALVINGS) as f32),
        thresholds,
        peak: ready.light.peak,
        rms_error: rms as f32,
        dark_error: dark as f32,
        rotation: ready.rotation[..components * ready.bands()].to_vec(),
    }
    .checked()
    .expect("fields were checked");
    let coarse_of = |c: usize| -> Vec<i16> {
        ready.coarse[c].iter().map(|v| libm::roundf(v / step).clamp(-32767.0, 32767.0) as i16).collect()
    };
    let has_coarse = coarse::edge(&pass.geometry.map) > 0;
    let averages = Averages {
        blocks: (0..components)
            .map(|c| coded.blocks.iter().skip(c).step_by(components).map(|b| b.values[0]).collect())
            .collect(),
        coarse: (0..if has_coarse { components } else { 0 }).map(coarse_of).collect(),
    };
    let order = head.order();
    let pages = page_ranges(coding, components, coded, settings.page_bytes)
        .into_iter()
        .map(|(first, count)| {
            let blocks = &coded.blocks[first * components..][..count * components];
            DetailPage {
                first: first as u32,
                count: count as u32,
                payload: detail::encode(coding, &order, components, blocks),
                priority: priority::of_detail(&head, coding, blocks),
            }
        })
        .collect();
    BasePayloads {
        base: ready.base,
        averages: averages.to_bytes(&pass.geometry.map),
        priority: priority::of_averages(&head, &coded.blocks),
        head,
        pages,
    }
}

/// Runs of blocks whose payloads fit a page; a block that does not fit by itself has one of its own.
fn page_ranges(coding: &Coding, components: usize, coded: &Coded, page_bytes: u32) -> Vec<(usize, usize)> {
    let length = |(i, block): (usize, &CodedBlock)| -> u64 {
        match coding {
            Coding::Classed(classes) => {
                let table = &classes.tables[Classes::table(i % components)];
                u64::from(table.class_bits() + bits(&table.widths()[usize::from(block.class)]))
            }
            Coding::Haar => {
                let kept = block.values[1..].iter().filter(|v| **v != 0).count() as u64;
                4 + if block.class > 0 { 64 } else { 0 } + kept * u64::from(block.class)
            }
        }
    };
    let lengths: Vec<u64> = coded.blocks.iter().enumerate().map(length).collect();
    let (mut ranges, mut first, mut held) = (Vec::new(), 0, 0);
    for (rank, block) in lengths.chunks_exact(components).enumerate() {
        let bits: u64 = block.iter().sum();
        if rank > first && held + bits > 8 * u64::from(page_bytes) {
            ranges.push((first, rank - first));
            (first, held) = (rank, 0);
        }
        held += bits;
    }
    ranges.push((first, lengths.len() / components - first));
    ranges
}
