//! Everything that a mesh file can say, and what is made of it: read, warned of, or without meaning for light.
//!
//! ```text
//! glTF 2.0 and its extensions -known::gltf-> ROWS;  OBJ and MTL -known::obj-> OBJ, MTL
//! JSON of a file -walk-> what of it is not read, once a kind
//! ```
//!
//! What is in no table is warned of by name, so that nothing falls through.

pub mod gltf;
pub mod obj;
pub mod page;
mod walk;

pub(crate) use walk::warn_of_unread;

/// Treatment of a part of a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// The part is read.
    Read,
    /// The part changes neither shape nor colour nor what light does, for the reason given.
    NoMeaning(&'static str),
    /// The part is not read, which a warning says: its consequence.
    Warned(&'static str),
    /// The part is warned of as by `Warned`, unless it has the value that means nothing, as JSON.
    WarnedUnless(&'static str, &'static str),
    /// A file that cannot do without is refused: what its user can do.
    Refused(&'static str),
}

impl Rule {
    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Rule::Read => "read",
            Rule::NoMeaning(_) => "no meaning for light",
            Rule::Warned(_) | Rule::WarnedUnless(..) => "warned of",
            Rule::Refused(_) => "refused where needed",
        }
    }

    /// Reason or advice beside the word.
    pub fn why(self) -> &'static str {
        match self {
            Rule::Read => "",
            Rule::NoMeaning(why) | Rule::Warned(why) | Rule::WarnedUnless(why, _) => why,
            Rule::Refused(advice) => advice.trim_start_matches("; "),
        }
    }
}

#[cfg(test)]
mod tests;
