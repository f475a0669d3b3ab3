//! The adaptive U-turn (being written).
