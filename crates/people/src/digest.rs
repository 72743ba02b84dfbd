//! SHA-256 digests and keyed pseudonyms, as hexadecimal text.

use sha2::{Digest, Sha256};
use std::fmt::Write;

/// The number of hexadecimal digits of a digest.
pub(crate) const DIGITS: usize = 64;

/// Bytes as hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(2 * bytes.len());
    for byte in bytes {
        // writing to a text does not fail
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// The SHA-256 of bytes.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// The HMAC-SHA-256 (RFC 2104) of `text` by a secret of at most a block.
pub(crate) fn keyed(secret: &[u8], text: &str) -> String {
    const BLOCK: usize = 64;
    let padded =
        |pad: u8| (0..BLOCK).map(|at| secret.get(at).copied().unwrap_or(0) ^ pad).collect::<Vec<u8>>();
    let inner = Sha256::new().chain_update(padded(0x36)).chain_update(text).finalize();
    hex(&Sha256::new().chain_update(padded(0x5c)).chain_update(inner).finalize())
}

/// Whether a text has the form of a digest.
pub(crate) fn is_digest(text: &str) -> bool {
    text.len() == DIGITS && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_digests_of_the_standards() {
        let of_abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), of_abc);
        // RFC 4231, test case 2
        let of_jefe = "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843";
        assert_eq!(keyed(b"Jefe", "what do ya want for nothing?"), of_jefe);
        assert!(is_digest(of_abc) && !is_digest("abc") && !is_digest(&of_abc.to_uppercase()));
    }
}
