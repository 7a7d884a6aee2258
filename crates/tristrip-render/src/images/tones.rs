//! Conversion between sRGB and linear light.

/// The linear intensity of each sRGB value.
pub(super) struct Tones {
    linear: [f32; 256],
}

impl Tones {
    pub(super) fn new() -> Self {
        let mut linear = [0.0; 256];
        for (value, light) in linear.iter_mut().enumerate() {
            let share = value as f64 / 255.0;
            let exact =
                if share <= 0.040_45 { share / 12.92 } else { libm::pow((share + 0.055) / 1.055, 2.4) };
            *light = exact as f32;
        }
        Self { linear }
    }

    pub(super) fn linear(&self, colour: [u8; 3]) -> [f32; 3] {
        colour.map(|value| self.linear[usize::from(value)])
    }

    /// Returns the nearest sRGB value of a linear intensity; ties round down.
    pub(super) fn encoded(&self, light: f32) -> u8 {
        let above = self.linear.partition_point(|&known| known <= light);
        match above {
            0 => 0,
            256 => 255,
            _ if light - self.linear[above - 1] > self.linear[above] - light => above as u8,
            _ => (above - 1) as u8,
        }
    }
}
