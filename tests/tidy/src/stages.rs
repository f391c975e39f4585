//! The stages of the planner in the documentation, compared with the calls in the planner.

/// The stages that a table names, in the rows after its heading.
pub fn documented(text: &str) -> Vec<&str> {
    let table = text.lines().skip_while(|line| !line.starts_with("| stage |")).skip(2);
    table.map_while(|row| row.strip_prefix("| `")?.split('`').next()).collect()
}

/// The functions that the statements of the planner call, in order; not those that check what a stage has made.
pub fn called(text: &str) -> Vec<&str> {
    let body = text.lines().skip_while(|line| !line.starts_with("fn plan_with_tables_up_to(")).skip(1);
    let statements = body.take_while(|line| !line.starts_with('}')).map(str::trim_start);
    statements.filter_map(stage).collect()
}

/// The function of a statement `stage(...)` or `let result = stage(...)`.
fn stage(statement: &str) -> Option<&str> {
    let call = match statement.strip_prefix("let ") {
        Some(binding) => binding.split_once(" = ")?.1,
        None => statement,
    };
    let name = call.split('(').next()?;
    let is_call = !name.is_empty() && name.len() < call.len();
    let is_function = is_call && name.chars().all(|c| c.is_ascii_lowercase() || c == '_');
    let is_stage = is_function && !name.starts_with("check_");
    is_stage.then(|| name.strip_prefix("add_").unwrap_or(name))
}

#[cfg(test)]
mod tests {
    use super::{called, documented};

    #[test]
    fn calls_of_statements_are_stages() {
        let text = "fn plan_with_tables_up_to(\n) {\n    let a = first(b)?;\n    check_it(a);\n    if c {\n        \
                    add_second(a);\n    }\n    let Third { d, e } = third(a);\n    f.g = h(a);\n}\nfn i() {\n    j();\n}\n";
        assert_eq!(called(text), ["first", "second", "third"]);
    }

    #[test]
    fn a_row_names_its_stage_first() {
        let text = "| stage | result |\n|---|---|\n| `first` | `a` |\n| `second` | b |\n\n| `c` |\n";
        assert_eq!(documented(text), ["first", "second"]);
    }
}
