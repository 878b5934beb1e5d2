//! What crosses a cable: versioned packets and their incremental decoder.
