//! The topics of `tristrip help`: texts that are too long for the help of a flag.

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
        text: || include_str!("topics/levels.txt").into(),
    },
    Topic {
        name: "simplification",
        summary: "How meshes are simplified, and what the options mean",
        text: || include_str!("topics/simplification.txt").into(),
    },
    Topic {
        name: "files",
        summary: "Formats, layouts of strips, and how files are written",
        text: || include_str!("topics/files.txt").into(),
    },
    Topic {
        name: "server",
        summary: "Addresses, packing, cache and limits of the web server",
        text: || include_str!("topics/server.txt").into(),
    },
];

impl Topic {
    /// Returns the topic of a name.
    pub(crate) fn find(name: &str) -> Option<&'static Self> {
        TOPICS.iter().find(|topic| topic.name == name)
    }

    /// Returns the text, in lines of up to 100 columns.
    pub(crate) fn text(&self) -> String {
        (self.text)()
    }
}
