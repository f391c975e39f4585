//! Conditions over facts: `when: "emissive and illuminance < 10"`.
