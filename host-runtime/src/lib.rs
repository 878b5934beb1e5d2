//! The host side of Tetrad.
