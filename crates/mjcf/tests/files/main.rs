//! MJCF files: read as MuJoCo reads them, refused where they have no meaning, accounted for to the last attribute.

mod account;
mod attach;
mod beside;
mod contacts;
mod faults;
mod golden;
mod height_fields;
mod hostile;
mod includes;
mod motion;
mod mutations;
mod pairs;
mod reading;
mod sensors;
mod soft;
