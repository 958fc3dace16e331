//! Tests of reading MJCF files, of refused files, and of the report.

mod account;
mod actuation;
mod adhesion;
mod attach;
mod contacts;
mod controllers;
mod derivatives;
mod faults;
mod fluid;
mod golden;
mod height_fields;
mod hostile;
mod includes;
mod meshes;
mod messages;
mod motion;
mod mutations;
mod pairs;
mod reading;
mod sensors;
mod soft;
