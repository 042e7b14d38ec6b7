//! Numbers from outside: tables, closed forms, second methods.

mod cutter_contact;
