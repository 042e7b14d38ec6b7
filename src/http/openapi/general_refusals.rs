//! Refusals that do not depend on what an operation does are written once, as the `default` response. The other
//! responses of an operation name its own refusals.

use serde_json::{Map, Value, json};

use super::{each_operation, is_refusal};
use crate::http::problem::ProblemType;
use crate::http::refusals::{OF_EVERY_OPERATION, responses_of_operation};

/// Refusals that come from the form of the request or from the caller. Most operations have them.
const OF_REQUESTS: [ProblemType; 10] = [
    ProblemType::MalformedRequest,
    ProblemType::UnreadableJson,
    ProblemType::Unauthenticated,
    ProblemType::ScopeMissing,
    ProblemType::ForeignPage,
    ProblemType::NotAcceptable,
    ProblemType::RequestTimeout,
    ProblemType::BodyTooLarge,
    ProblemType::UnsupportedMediaType,
    ProblemType::InvalidRequest,
];

fn general() -> impl Iterator<Item = ProblemType> {
    OF_REQUESTS.into_iter().chain(OF_EVERY_OPERATION)
}

/// Puts one response `default` in the place of the general refusals.
pub(super) fn gather(document: &mut Value) {
    let listed: Vec<(String, Value)> = responses_of_operation(&OF_REQUESTS)
        .into_iter()
        .map(|(status, response)| (status, serde_json::to_value(response).unwrap_or_default()))
        .collect();
    let words: Vec<String> =
        listed.iter().map(|(status, response)| format!("{status} {}", described(response))).collect();
    let description = format!(
        "Any operation can give these refusals, also beside its own refusals with the same status: {}",
        words.join("; ")
    );
    let mut gathered = json!({ "description": description });
    for part in ["content", "headers"] {
        if let Some(found) = listed.iter().find_map(|(_, response)| response.get(part)) {
            gathered[part] = found.clone();
        }
    }
    each_operation(document, |operation, _| {
        let Some(responses) = operation.get_mut("responses").and_then(Value::as_object_mut) else { return };
        take_general(responses);
        responses.insert("default".to_owned(), gathered.clone());
    });
}

/// Leaves the refusals that are not general, and the responses that have any. One response stays where an operation
/// would have no refusal of a request: readers of the strict kind ask for one.
fn take_general(responses: &mut Map<String, Value>) {
    let first = responses.iter().find(|(status, _)| status.starts_with('4'));
    let first = first.map(|(status, response)| (status.clone(), response.clone()));
    responses.retain(|status, response| {
        if !is_refusal(status) {
            return true;
        }
        let own: Vec<&str> = described(response).split("; ").filter(|title| !is_general(title)).collect();
        let own = own.join("; ");
        let has_own = !own.is_empty();
        response["description"] = Value::from(own);
        has_own
    });
    if !responses.keys().any(|status| status.starts_with('4')) {
        responses.extend(first);
    }
}

fn is_general(title: &str) -> bool {
    general().any(|kind| title.ends_with(&format!("(`{}`)", kind.code())))
}

fn described(response: &Value) -> &str {
    response.get("description").and_then(Value::as_str).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn general_refusals_are_one_default_response() {
        let own = [ProblemType::QueueFull, ProblemType::JobNotFound];
        let all = responses_of_operation(&[&OF_REQUESTS[..], &own].concat());
        let mut listed = serde_json::to_value(all).unwrap();
        listed["200"] = json!({ "description": "The job" });
        let mut document = json!({ "paths": {"/a": {"get": { "operationId": "a", "responses": listed }}} });
        gather(&mut document);
        let responses = document["paths"]["/a"]["get"]["responses"].as_object().unwrap();
        assert_eq!(responses.keys().collect::<Vec<_>>(), ["200", "404", "503", "default"]);
        assert_eq!(described(&responses["503"]), "The queue is full (`queue-full`)");
        let said = described(&responses["default"]);
        for kind in general() {
            assert!(said.contains(&format!("(`{}`)", kind.code())), "{said}");
        }
        assert!(said.contains("; 429 ") && !said.contains("queue-full"), "{said}");
        assert!(responses["default"]["headers"]["Retry-After"].is_object());
    }

    #[test]
    fn titles_can_be_told_apart_in_a_list() {
        assert!(ProblemType::ALL.iter().all(|kind| !kind.title().contains(';')));
    }

    #[test]
    fn an_operation_names_one_refusal_of_a_request() {
        let mut listed = serde_json::to_value(responses_of_operation(&OF_REQUESTS)).unwrap();
        let responses = listed.as_object_mut().unwrap();
        take_general(responses);
        assert_eq!(responses.keys().collect::<Vec<_>>(), ["400"]);
    }
}
