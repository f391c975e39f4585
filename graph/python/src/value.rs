//! Values of parameters, in Python and as a pipeline file writes them.

use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::value::{Type, Value};
use pyo3::IntoPyObjectExt as _;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use serde_json::json;

use crate::error::Failure;

/// The value as a Python object: a number, a flag, a text or a tuple of numbers.
pub(crate) fn to_python(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    match value {
        Value::Bool(flag) => flag.into_py_any(py),
        Value::Int(number) => number.into_py_any(py),
        Value::Float(number) => number.into_py_any(py),
        Value::Vector(numbers, count) => PyTuple::new(py, &numbers[..*count])?.into_py_any(py),
        Value::Choice(name) => name.into_py_any(py),
        Value::Text(text) => text.into_py_any(py),
        Value::File(file) => file.path.to_string().into_py_any(py),
    }
}

/// A Python object as a pipeline file writes a value of this type; `None` for a switch of a node. The check reports
/// what has another type.
pub(crate) fn to_text(value: &Bound<'_, PyAny>, ty: Option<Type>) -> PyResult<String> {
    if let Ok(flag) = value.extract::<bool>() {
        let (on, off) = if ty.is_none() { ("On", "Off") } else { ("true", "false") };
        return Ok(if flag { on } else { off }.to_owned());
    }
    if let Ok(number) = value.extract::<i64>() {
        return Ok(number.to_string());
    }
    if let Ok(number) = value.extract::<f64>() {
        return if number.is_finite() { Ok(format!("{number:?}")) } else { Err(not_finite(number)) };
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(if matches!(ty, Some(Type::Text | Type::File)) { format!("{text:?}") } else { text });
    }
    let numbers: Vec<f64> = value.extract()?;
    if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
        return Err(not_finite(*number));
    }
    let texts: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
    Ok(format!("({})", texts.join(", ")))
}

fn not_finite(number: f64) -> PyErr {
    Failure::Parameter(format!("a parameter must be finite, not {number}")).into()
}

/// The declaration of a parameter, for `Pipeline.parameters`.
pub(crate) fn declaration(graph: &Graph, id: ParameterId) -> serde_json::Value {
    let param = graph.declaration(id);
    let choices: Vec<_> = match param.ty {
        Type::Choice(choices) => choices.iter().map(|choice| [choice.name, choice.doc]).collect(),
        _ => Vec::new(),
    };
    json!({
        "name": graph.parameter_name(id),
        "kind": graph.nodes[id.node].kind().name(),
        "doc": param.doc,
        "type": param.ty.describe().replace('`', ""),
        "unit": &*param.unit,
        "domain": param.domain,
        "usual": param.usual,
        "choices": choices,
    })
}
