//! The parts of which a report is made: tables, lists, symbols, numbers.

/// Text as HTML shows it.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A table of names and values; the values are HTML.
pub(super) fn facts(rows: &[(&str, String)]) -> String {
    let rows: Vec<String> = rows
        .iter()
        .map(|(name, value)| format!("<tr><th scope=row>{name}</th><td>{value}</td></tr>"))
        .collect();
    format!("<table class=facts>\n{}\n</table>", rows.join("\n"))
}

/// A table of this class under a row of column names; names and cells are HTML. Cells from column `numbers_from` on are
/// numbers.
pub(super) fn table(class: &str, columns: &[&str], numbers_from: usize, rows: &[Vec<String>]) -> String {
    let class_of = |column: usize| if column >= numbers_from { " class=n" } else { "" };
    let head = columns.iter().enumerate();
    let head: Vec<String> =
        head.map(|(column, name)| format!("<th scope=col{}>{name}</th>", class_of(column))).collect();
    let rows: Vec<String> = rows
        .iter()
        .map(|row| {
            let cells = row.iter().enumerate();
            let cells = cells.map(|(column, cell)| format!("<td{}>{cell}</td>", class_of(column)));
            format!("<tr>{}</tr>", cells.collect::<Vec<_>>().concat())
        })
        .collect();
    format!(
        "<table class={class}>\n<thead><tr>{}</tr></thead>\n<tbody>\n{}\n</tbody>\n</table>",
        head.concat(),
        rows.join("\n")
    )
}

/// A section under a heading; empty text for an empty section.
pub(super) fn section(heading: &str, content: &str) -> String {
    if content.is_empty() {
        return String::new();
    }
    format!("<section>\n<h2>{heading}</h2>\n{content}\n</section>")
}

/// A list; empty text for an empty list. Items are HTML.
pub(super) fn list(items: impl IntoIterator<Item = String>) -> String {
    let items: Vec<String> = items.into_iter().map(|item| format!("<li>{item}</li>")).collect();
    if items.is_empty() { String::new() } else { format!("<ul>\n{}\n</ul>", items.join("\n")) }
}

/// `E_A0C_urad` as ISO 230-7 writes it, with its unit.
pub(super) fn symbol(name: &str) -> String {
    let (symbol, unit) = split_unit(name);
    match symbol.split_once('_') {
        Some((letter, place)) => format!("<i>{letter}</i><sub>{place}</sub> [{unit}]"),
        None => format!("{symbol} [{unit}]"),
    }
}

/// A name without its unit, and the unit as people write it.
pub(super) fn split_unit(name: &str) -> (&str, &'static str) {
    match (name.strip_suffix("_urad"), name.strip_suffix("_um")) {
        (Some(symbol), _) => (symbol, "µrad"),
        (None, Some(symbol)) => (symbol, "µm"),
        (None, None) => (name, ""),
    }
}

/// A number with this many decimals and a real minus sign; zero has none.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|byte| matches!(byte, b'0' | b'.')) => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// The shortest form of a number that was given.
pub(super) fn given(value: f64) -> String {
    value.to_string().replace('-', "−")
}

/// Decimals with which an uncertainty has two significant digits, at most four.
pub(super) fn decimals(uncertainty: Option<f64>) -> usize {
    // 0.996 is written as 1.0, with one decimal.
    match uncertainty {
        Some(value) if value >= 9.95 => 0,
        Some(value) if value >= 0.995 => 1,
        Some(value) if value >= 0.0995 => 2,
        Some(value) if value >= 0.00995 => 3,
        Some(_) => 4,
        None => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_a_metrologist_writes_them() {
        assert_eq!(number(-21.04, 1), "−21.0");
        assert_eq!(number(-0.004, 2), "0.00");
        assert_eq!(given(-0.5), "−0.5");
        for (uncertainty, written) in
            [(12.3, "12"), (9.96, "10"), (1.23, "1.2"), (0.46, "0.46"), (0.0123, "0.012")]
        {
            assert_eq!(number(uncertainty, decimals(Some(uncertainty))), written);
        }
        assert_eq!(symbol("E_A0C_urad"), "<i>E</i><sub>A0C</sub> [µrad]");
        assert_eq!(escaped("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
    }
}
