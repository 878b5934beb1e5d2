//! Two (or up to eight) cameras become one hand: section 4 of the paper.
