//! The page itself: its parts, its description and its block in one text.

use crate::Contents;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/style.css");
/// In the order in which they need each other.
const SCRIPTS: [&str; 10] = [
    include_str!("page/numbers.js"),
    include_str!("page/data.js"),
    include_str!("page/summary.js"),
    include_str!("page/charts.js"),
    include_str!("page/geometry.js"),
    include_str!("page/shaders.js"),
    include_str!("page/renderer.js"),
    include_str!("page/camera.js"),
    include_str!("page/player.js"),
    include_str!("page/main.js"),
];

/// Whether a page asks where it came from how the run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It is complete.
    File,
    /// It was served by `watch`.
    Live,
}

/// The whole page.
pub fn text(contents: &Contents, kind: Kind) -> String {
    let title = contents.description["name"].as_str().unwrap_or_default();
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    let scripts = SCRIPTS.concat();
    let parts = [
        ("{{title}}", title.as_str()),
        ("{{style}}", STYLE),
        ("{{live}}", if kind == Kind::Live { "true" } else { "false" }),
        ("{{description}}", &description(contents)),
        ("{{block}}", &contents.block),
        ("{{scripts}}", &scripts),
    ];
    // Each place is filled once, and what fills it is not looked at again.
    let (mut page, mut rest) = (String::new(), PAGE);
    for (place, part) in parts {
        if let Some((before, after)) = rest.split_once(place) {
            page.extend([before, part]);
            rest = after;
        }
    }
    page + rest
}

/// The description as JSON that may stand in a page: no text of a case ends a script.
pub fn description(contents: &Contents) -> String {
    contents
        .description
        .to_string()
        .replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_part_is_in_the_page_and_nothing_comes_from_elsewhere() {
        let description = json!({ "name": "a </script><b> & {{block}}" });
        let page = text(&Contents { description, block: "QUJD".into(), is_thinned: false }, Kind::File);
        assert!(!page.contains("{{style}}") && !page.contains("{{scripts}}") && !page.contains("{{live}}"));
        assert_eq!(page.matches("</script>").count(), PAGE.matches("</script>").count());
        assert!(page.contains("QUJD"));
        for forbidden in ["http:", "https:", "@import", "src=\"//"] {
            // The name space of SVG is no address.
            let elsewhere = page.replace("http://www.w3.org/2000/svg", "");
            assert!(!elsewhere.contains(forbidden), "{forbidden}");
        }
    }
}
