//! The sites that hold matter, and where their light comes from: medium -> sparse links.
//!
//! Light crosses empty sites unchanged, so along each of the 18 directions a site receives what the
//! nearest upstream non-empty site sent that way, or the boundary light. Those links are found once.
//!
//! Sites are cut into domains, contiguous in the sweep's order, so that a solve can run in parallel in
//! space: each domain owns its light and sees the others' through copies made between sweeps. The cut
//! depends on the site count alone, so results do not depend on the number of threads.

use flb_format::Medium;
use flb_format::direction::{DIRECTIONS, MOVING};
use flb_format::matter::Class;
use rayon::prelude::*;

/// Sites per domain at most. Light crosses from one domain to the next only between sweeps, and echoes between wood
/// sites of two domains are not summed, which costs sweeps where a cut meets the trunk (an oak at lattice 256 in three
/// domains: a quarter more): so plants are one domain up to that lattice, and only denser ones are cut.
pub(super) const DOMAIN_SITES: usize = 1_048_576;

/// Sites are swept cluster by cluster, so that a cluster's light stays in the cache; sites per cluster edge. Light that
/// crosses a cluster's edge against the order waits for the next sweep: an oak at lattice 128 needs 21 sweeps with 16,
/// 18 with 32 or 64. With 128, an oak at lattice 256 leaves the cache and takes 1.4 times as long as with 64.
const CLUSTER: usize = 64;

const EMPTY: u32 = u32::MAX;

/// All non-empty sites of a medium.
#[derive(Debug, Clone)]
pub(super) struct Sites {
    /// N.
    pub lattice: usize,
    /// Number of non-empty sites.
    pub count: usize,
    /// Domains in the sweep's order.
    pub domains: Vec<Domain>,
    /// `[z]`: the plane's non-empty sites, by y, then x.
    pub planes: Vec<Vec<LatticeSite>>,
}

/// A non-empty site of a plane and where its light is kept.
#[derive(Debug, Clone, Copy)]
pub(super) struct LatticeSite {
    /// Lattice coordinates.
    pub x: u16,
    /// Lattice coordinates.
    pub y: u16,
    /// Index into [`Sites::domains`].
    pub domain: u32,
    /// Index of the site within the domain.
    pub site: u32,
}

/// A contiguous run of sites. A row is one site's outgoing light in one direction. Row
/// `site * 18 + m - 1` belongs to a site of this domain; then come 18 rows of boundary light, `[m - 1]`;
/// then one row per entry of `halo`.
#[derive(Debug, Clone, Default)]
pub(super) struct Domain {
    /// Density per site.
    pub rho: Vec<f32>,
    /// Whether a site is wood.
    pub wood: Vec<bool>,
    /// `[site][m - 1]`: the row whose light arrives along direction m.
    pub links: Vec<[u32; MOVING]>,
    /// Bit m - 1 per site: this is wood, and what it sends along m goes first to wood of this domain.
    pub echoes: Vec<u32>,
    /// Ends of the clusters, as site indices.
    pub clusters: Vec<u32>,
    /// Rows that other domains copy.
    pub exports: Vec<u32>,
    /// Source of each halo row: domain and index into its `exports`.
    pub halo: Vec<(u32, u32)>,
}

impl Domain {
    /// Number of sites.
    pub(super) fn len(&self) -> usize {
        self.rho.len()
    }

    /// Rows of sites, boundary and halo.
    pub(super) fn rows(&self) -> usize {
        (self.len() + 1) * MOVING + self.halo.len()
    }
}

/// Finds the sites and their links, `domain_sites` ([`DOMAIN_SITES`]) sites per domain at most. The medium's
/// outermost layer is empty (checked by `solve`).
pub(super) fn find(medium: &Medium, domain_sites: usize) -> Sites {
    let n = medium.grid.lattice as usize;
    // Height first: a cut between domains is then level and meets a trunk in few sites. The same within a
    // cluster, so that light of most directions meets sites and clusters in one and the same order.
    let place = |index: usize, edge: usize| {
        let [x, y, z] = medium.grid.site(index).map(|c| c as usize / edge);
        (y * n + z) * n + x
    };
    let cluster_of = |index: usize| place(index, CLUSTER);
    let mut order: Vec<u32> =
        (0..n * n * n).filter(|&i| medium.class[i] != Class::Empty).map(|i| i as u32).collect();
    order.sort_by_cached_key(|&index| (cluster_of(index as usize), place(index as usize, 1)));
    let count = order.len();
    let domain_count = count.div_ceil(domain_sites).max(1);
    let per_domain = count.div_ceil(domain_count).max(1);

    let mut rank = vec![EMPTY; n * n * n];
    for (at, &index) in order.iter().enumerate() {
        rank[index as usize] = at as u32;
    }

    // Links as (rank of the giver), still global.
    let mut domains: Vec<Domain> = order
        .par_chunks(per_domain)
        .enumerate()
        .map(|(domain, sites)| link(medium, &rank, domain * per_domain, cluster_of, sites))
        .collect();
    connect(&mut domains, per_domain);

    let mut planes = vec![Vec::new(); n];
    for (index, &at) in rank.iter().enumerate().filter(|(_, at)| **at != EMPTY) {
        let (domain, site) = (at as usize / per_domain, at as usize % per_domain);
        let [x, y, z] = medium.grid.site(index);
        planes[z as usize].push(LatticeSite {
            x: x as u16,
            y: y as u16,
            domain: domain as u32,
            site: site as u32,
        });
    }
    Sites { lattice: n, count, domains, planes }
}

/// One domain, its links to other domains still pending in `halo` as (global rank, direction).
fn link(
    medium: &Medium,
    rank: &[u32],
    first: usize,
    cluster_of: impl Fn(usize) -> usize,
    sites: &[u32],
) -> Domain {
    let n = medium.grid.lattice as usize;
    let steps: [isize; MOVING] = std::array::from_fn(|m| {
        let [x, y, z] = DIRECTIONS[m + 1].map(|c| c as isize);
        x + n as isize * (y + n as isize * z)
    });
    let boundary = sites.len() * MOVING;
    let mut domain = Domain::default();
    for (at, &index) in sites.iter().enumerate() {
        let index = index as usize;
        domain.rho.push(medium.density[index]);
        domain.wood.push(medium.class[index] == Class::Wood);
        let position = medium.grid.site(index).map(|c| c as usize);
        let links = std::array::from_fn(|m| {
            // Steps back to the boundary layer along this direction.
            let reach = (0..3).filter_map(|axis| match DIRECTIONS[m + 1][axis] {
                0 => None,
                1 => Some(position[axis]),
                _ => Some(n - 1 - position[axis]),
            });
            let reach = reach.min().unwrap_or(0);
            let giver = (1..reach)
                .map(|back| rank[(index as isize - steps[m] * back as isize) as usize])
                .find(|&giver| giver != EMPTY);
            match giver {
                None => (boundary + m) as u32,
                Some(giver) if (first..first + sites.len()).contains(&(giver as usize)) => {
                    ((giver as usize - first) * MOVING + m) as u32
                }
                Some(giver) => {
                    domain.halo.push((giver, m as u32));
                    (boundary + MOVING + domain.halo.len() - 1) as u32
                }
            }
        });
        domain.links.push(links);
        let ends = sites.get(at + 1).is_none_or(|&next| cluster_of(next as usize) != cluster_of(index));
        if ends {
            domain.clusters.push(at as u32 + 1);
        }
    }
    let wood = |row: u32| domain.wood.get(row as usize / MOVING).is_some_and(|wood| *wood);
    let echoes = |(links, of_wood): (&[u32; MOVING], &bool)| match of_wood {
        // Opposites are neighbours: from where light arrives against m, there m leads.
        true => (0..MOVING).filter(|m| wood(links[m ^ 1])).map(|m| 1 << m).sum(),
        false => 0,
    };
    let echoes = domain.links.iter().zip(&domain.wood).map(echoes).collect();
    domain.echoes = echoes;
    domain
}

/// Turns pending halo entries into (domain, export).
fn connect(domains: &mut [Domain], per_domain: usize) {
    for at in 0..domains.len() {
        let mut halo = std::mem::take(&mut domains[at].halo);
        for (giver, m) in &mut halo {
            let owner = *giver as usize / per_domain;
            let exports = &mut domains[owner].exports;
            exports.push(((*giver as usize % per_domain) * MOVING) as u32 + *m);
            (*giver, *m) = (owner as u32, exports.len() as u32 - 1);
        }
        domains[at].halo = halo;
    }
}
