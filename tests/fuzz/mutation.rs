//! Random changes of bytes and of texts.

/// SplitMix64 (Steele et al. 2014): a seed gives the same numbers everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A number below `end`, which is above 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    pub fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }

    /// Changes one to four places of `bytes`.
    pub fn change_bytes(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..=self.below(4) {
            if bytes.is_empty() {
                return;
            }
            let at = self.below(bytes.len());
            let width = (1 << self.below(4)).min(bytes.len() - at);
            match self.below(6) {
                0 => bytes[at] ^= 1 << self.below(8),
                1 => bytes[at..at + width].fill(0xff),
                2 => bytes[at..at + width].fill(0),
                3 => drop(bytes.drain(at..at + width)),
                4 => {
                    let copied = bytes[at..at + width].to_vec();
                    let to = self.below(bytes.len());
                    bytes.splice(to..to, copied);
                }
                _ => bytes[at] = self.next() as u8,
            }
        }
    }

    /// Changes one to three words, numbers or signs of a text.
    pub fn change_text(&mut self, text: &str) -> String {
        const SPLICED: [&str; 20] = [
            "0",
            "-1",
            "1",
            "255",
            "4294967295",
            "4294967296",
            "18446744073709551615",
            "1e308",
            "-1e-320",
            "NaN",
            "inf",
            "\"\"",
            "(",
            ")",
            "[",
            "{",
            ",",
            "Some(",
            "()",
            "\u{1F980}",
        ];
        let mut words = words(text);
        for _ in 0..=self.below(3) {
            if words.is_empty() {
                break;
            }
            let at = self.below(words.len());
            match self.below(5) {
                0 => drop(words.remove(at)),
                1 => words[at] = (*self.of(&SPLICED)).into(),
                2 => {
                    let copied = words[self.below(words.len())].clone();
                    words.insert(at, copied);
                }
                3 => {
                    let other = self.below(words.len());
                    words.swap(at, other);
                }
                // A number where one stands keeps the rest of the text valid.
                _ => {
                    if let Some(number) =
                        words.iter().skip(at).position(|word| word.starts_with(|it: char| it.is_ascii_digit()))
                    {
                        words[at + number] = (*self.of(&SPLICED[..11])).into();
                    }
                }
            }
        }
        words.concat()
    }
}

/// A text as words, numbers, blanks and signs.
fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let kind = |letter: char| match letter {
        _ if letter.is_alphanumeric() || letter == '_' || letter == '.' => 1,
        _ if letter.is_whitespace() => 2,
        _ => 3,
    };
    let mut last = 0;
    for letter in text.chars() {
        let now = kind(letter);
        match words.last_mut() {
            Some(word) if now == last && now != 3 => word.push(letter),
            _ => words.push(letter.into()),
        }
        last = now;
    }
    words
}
