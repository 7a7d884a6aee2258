//! The topics of `tristrip help`: text that is too long for the help of a flag.

use std::fmt::Write as _;

use tristrip::lod::ModelKind;
use tristrip_pipeline::levels::DisplayFilter;

/// A topic of `tristrip help`.
pub(crate) struct Topic {
    pub(crate) name: &'static str,
    pub(crate) summary: &'static str,
    text: fn() -> String,
}

/// All topics.
pub(crate) static TOPICS: [Topic; 5] = [
    Topic {
        name: "methods",
        summary: "Stripification methods and their parameters",
        text: || format!("{}\n{}", include_str!("topics/methods.txt"), tristrip_pipeline::method_help()),
    },
    Topic {
        name: "levels",
        summary: "Levels of detail, filters, level models, cameras and chains",
        text: levels,
    },
    Topic {
        name: "simplification",
        summary: "How meshes are simplified, and what the options do",
        text: || include_str!("topics/simplification.txt").into(),
    },
    Topic {
        name: "files",
        summary: "File formats, strip layouts, and how files are written",
        text: || include_str!("topics/files.txt").into(),
    },
    Topic {
        name: "server",
        summary: "Paths, addresses, packing, cache and limits of the web server",
        text: || include_str!("topics/server.txt").into(),
    },
];

impl Topic {
    /// Returns the topic with this name.
    pub(crate) fn find(name: &str) -> Option<&'static Self> {
        TOPICS.iter().find(|topic| topic.name == name)
    }

    /// Returns the text, wrapped at 100 columns.
    pub(crate) fn text(&self) -> String {
        (self.text)()
    }
}

/// Returns the names of all topics, separated by commas.
pub(crate) fn topic_names() -> String {
    TOPICS.each_ref().map(|topic| topic.name).join(", ")
}

/// Returns the text of `levels` with the filters and level models of the library.
fn levels() -> String {
    let filters = DisplayFilter::ALL.iter().map(|filter| (filter.name(), filter.summary()));
    let models = ModelKind::ALL.iter().map(|model| (model.name(), model.summary()));
    let text = include_str!("topics/levels.txt");
    format!("{text}\nFilters\n{}\nLevel models\n{}", entries(filters), entries(models))
}

/// Returns one entry per name with its summary next to it, wrapped at 100 columns.
fn entries<'a>(entries: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let mut text = String::new();
    for (name, summary) in entries {
        let mut line = format!("  {name:<16}");
        for word in summary.split_whitespace() {
            if line.len() + 1 + word.len() > 100 {
                let _ = writeln!(text, "{line}");
                line = format!("{:18}", "");
            }
            line.push(' ');
            line.push_str(word);
        }
        let _ = writeln!(text, "{line}");
    }
    text
}
