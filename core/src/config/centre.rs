//! How a ball's centre is measured.

/// Which measure of the centre is reported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CentreMode {
    /// The paper's: eq. 2 over the row edges.
    RowEdge,
    /// A robust fit to the sub-pixel rim.
    #[default]
    Refined,
}

/// The centre of a ball.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CentreConfig {
    /// Which measure is reported.
    pub mode: CentreMode,
}
