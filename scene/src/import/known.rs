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

/// What is made of a thing that a file can say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// It is read.
    Read,
    /// It changes neither shape nor colour nor what light does, for the reason given.
    NoMeaning(&'static str),
    /// It is not read, which is said: what that means.
    Warned(&'static str),
    /// The same, unless it has the value that means nothing, as JSON.
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

    /// What there is to say beside the word.
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
