//! The description of the interface costs a quarter of the build, and only tests make it: the binary has the committed
//! file. These macros stand where the description is written, and leave it out of every other build.

use proc_macro::{Delimiter, Group, TokenStream, TokenTree};

/// The derive of `utoipa::ToSchema` in a build that makes no description. It adds nothing.
#[proc_macro_derive(ToSchema, attributes(schema))]
pub fn to_schema(_: TokenStream) -> TokenStream {
    TokenStream::new()
}

/// The derive of `utoipa::IntoParams` in a build that makes no description. It adds nothing.
#[proc_macro_derive(IntoParams, attributes(param, into_params))]
pub fn into_params(_: TokenStream) -> TokenStream {
    TokenStream::new()
}

/// `#[operation(get, path = "/v1/…", …)]` over a handler. It adds a constant with the method and the path of its
/// route, `ROUTE_OF_` and the handler's name. A test build also gets `#[utoipa::path(…)]` with the same words.
#[proc_macro_attribute]
pub fn operation(words: TokenStream, handler: TokenStream) -> TokenStream {
    match expanded(words, handler) {
        Ok(tokens) => tokens,
        Err(fault) => format!("compile_error!({fault:?});").parse().unwrap_or_default(),
    }
}

fn expanded(words: TokenStream, handler: TokenStream) -> Result<TokenStream, String> {
    let method = match words.clone().into_iter().next() {
        Some(TokenTree::Ident(method)) => method.to_string().to_uppercase(),
        _ => return Err("the first word is the method, like get".to_owned()),
    };
    let path = value_of("path", words.clone()).ok_or("state the path of the route: path = \"/v1/…\"")?;
    let name = name_of(handler.clone()).ok_or("an operation is a function")?.to_uppercase();
    let route =
        format!("pub(super) const ROUTE_OF_{name}: crate::http::described::Route = ({method:?}, {path});");
    let route: TokenStream = route.parse().map_err(|fault| format!("{fault}"))?;
    Ok(description(words)?.into_iter().chain(handler).chain(route).collect())
}

/// `#[cfg_attr(test, utoipa::path(words))]`. The words keep their places in the source for the compiler's messages.
fn description(words: TokenStream) -> Result<TokenStream, String> {
    let tokens = |text: &str| text.parse::<TokenStream>().map_err(|fault| format!("{fault}"));
    let group = |delimiter, inside| TokenStream::from(TokenTree::from(Group::new(delimiter, inside)));
    let path = [tokens("test, utoipa::path")?, group(Delimiter::Parenthesis, words)];
    let attribute = [tokens("cfg_attr")?, group(Delimiter::Parenthesis, path.into_iter().collect())];
    let bracket = group(Delimiter::Bracket, attribute.into_iter().collect());
    Ok(tokens("#")?.into_iter().chain(bracket).collect())
}

/// The literal after `name =` among words separated by commas.
fn value_of(name: &str, words: TokenStream) -> Option<String> {
    let words: Vec<TokenTree> = words.into_iter().collect();
    words.windows(3).find_map(|three| match three {
        [TokenTree::Ident(found), TokenTree::Punct(equal), TokenTree::Literal(value)]
            if found.to_string() == name && equal.as_char() == '=' =>
        {
            Some(value.to_string())
        }
        _ => None,
    })
}

/// The name after `fn`.
fn name_of(item: TokenStream) -> Option<String> {
    let mut tokens = item.into_iter().skip_while(|token| match token {
        TokenTree::Ident(word) => word.to_string() != "fn",
        TokenTree::Group(group) => group.delimiter() != Delimiter::Brace,
        _ => true,
    });
    tokens.next();
    tokens.next().map(|name| name.to_string())
}
