//! Computes the cost of a collapse. It includes the distance of the surface from the full mesh,
//! measured with quadrics or at all removed points, and the deviation of the attributes.

pub(crate) mod attribute_quadrics;
pub(crate) mod attributes;
pub(crate) mod best_collapse;
pub(crate) mod box_tree;
pub(crate) mod deviation;
pub(crate) mod fan;
pub(crate) mod frame;
pub(crate) mod neighbourhood;
pub(crate) mod priced_surface;
pub(crate) mod quadric;
pub(crate) mod removed_points;
pub(crate) mod search;
pub(crate) mod skin;
