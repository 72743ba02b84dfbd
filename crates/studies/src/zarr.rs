//! Arrays with named dimensions in groups, as a Zarr store in one ZIP file.
//!
//! The format is Zarr 2, uncompressed, one chunk for each array, with the attributes that xarray reads: ArviZ
//! 0.23 takes only this version. The crate zarrs writes version 3, and brings 136 crates; a store of this kind
//! is a handful of small JSON texts next to the numbers.

use serde_json::{Map, Value, json};
use std::io::{Cursor, Write};
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// The numbers or texts of an array, the last dimension fastest.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Floating-point numbers; NaN where there is none.
    Numbers(Vec<f64>),
    /// Whole numbers.
    Indices(Vec<i64>),
    /// Texts.
    Texts(Vec<String>),
}

/// An array. One with the name of its only dimension is the coordinate of that dimension.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Name.
    pub name: String,
    /// Its dimensions, each with its length.
    pub dimensions: Vec<(String, usize)>,
    /// Its values.
    pub values: Values,
}

/// A group of arrays, which share their dimensions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ZarrGroup {
    /// Name.
    pub name: String,
    /// Arrays.
    pub arrays: Vec<Array>,
}

/// A store.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Store {
    /// Attributes of the whole.
    pub attributes: Map<String, Value>,
    /// Groups.
    pub groups: Vec<ZarrGroup>,
}

impl Values {
    /// The type in Zarr 2.
    fn kind(&self) -> String {
        match self {
            Self::Numbers(_) => "<f8".to_owned(),
            Self::Indices(_) => "<i8".to_owned(),
            Self::Texts(texts) => format!("<U{}", longest(texts)),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Numbers(all) => all.iter().flat_map(|number| number.to_le_bytes()).collect(),
            Self::Indices(all) => all.iter().flat_map(|number| number.to_le_bytes()).collect(),
            Self::Texts(texts) => {
                let length = longest(texts);
                let padded = |text: &String| {
                    let letters: Vec<u32> = text.chars().map(u32::from).collect();
                    letters.into_iter().chain(std::iter::repeat(0)).take(length).collect::<Vec<u32>>()
                };
                texts.iter().flat_map(padded).flat_map(u32::to_le_bytes).collect()
            }
        }
    }
}

/// The number of letters of the longest text, at least 1.
fn longest(texts: &[String]) -> usize {
    texts.iter().map(|text| text.chars().count()).max().unwrap_or_default().max(1)
}

impl Array {
    fn shape(&self) -> Vec<usize> {
        self.dimensions.iter().map(|(_, length)| *length).collect()
    }

    fn metadata(&self) -> [(&'static str, Value); 2] {
        let shape = self.shape();
        let array = json!({
            "zarr_format": 2,
            "shape": shape,
            // a chunk has at least one element
            "chunks": shape.iter().map(|length| (*length).max(1)).collect::<Vec<_>>(),
            "dtype": self.values.kind(),
            "order": "C",
            "compressor": null,
            "filters": null,
            "fill_value": null,
        });
        let names: Vec<&String> = self.dimensions.iter().map(|(name, _)| name).collect();
        [(".zarray", array), (".zattrs", json!({ "_ARRAY_DIMENSIONS": names }))]
    }

    /// The file of the only chunk.
    fn chunk(&self) -> String {
        vec!["0"; self.dimensions.len().max(1)].join(".")
    }
}

impl Store {
    /// The store as a ZIP file, without times, so that equal stores have equal bytes.
    ///
    /// # Errors
    /// An array larger than ZIP files take.
    pub fn zipped(&self) -> ZipResult<Vec<u8>> {
        let group = json!({ "zarr_format": 2 });
        let mut texts: Vec<(String, Value)> = vec![
            (".zgroup".to_owned(), group.clone()),
            (".zattrs".to_owned(), Value::Object(self.attributes.clone())),
        ];
        let mut chunks = Vec::new();
        for ZarrGroup { name, arrays } in &self.groups {
            texts.push((format!("{name}/.zgroup"), group.clone()));
            texts.push((format!("{name}/.zattrs"), json!({})));
            for array in arrays {
                let folder = format!("{name}/{}", array.name);
                let own = array.metadata().map(|(file, value)| (format!("{folder}/{file}"), value));
                texts.extend(own);
                if !array.shape().contains(&0) {
                    chunks.push((format!("{folder}/{}", array.chunk()), array.values.bytes()));
                }
            }
        }
        let all: Map<String, Value> = texts.iter().cloned().collect();
        texts.push((".zmetadata".to_owned(), json!({ "zarr_consolidated_format": 1, "metadata": all })));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let texts = texts.into_iter().map(|(name, value)| (name, value.to_string().into_bytes()));
        for (name, bytes) in texts.chain(chunks) {
            zip.start_file(name, options)?;
            zip.write_all(&bytes)?;
        }
        Ok(zip.finish()?.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_bytes_of_values() {
        let texts = Values::Texts(vec!["ä".to_owned(), "bc".to_owned()]);
        assert_eq!(texts.kind(), "<U2");
        assert_eq!(texts.bytes(), [228, 0, 0, 0, 0, 0, 0, 0, 98, 0, 0, 0, 99, 0, 0, 0]);
        assert_eq!(Values::Indices(vec![-2]).bytes(), (-2i64).to_le_bytes());
        assert_eq!(Values::Numbers(vec![0.5]).bytes(), 0.5f64.to_le_bytes());
        assert_eq!(Values::Texts(Vec::new()).kind(), "<U1");
    }

    #[test]
    fn golden_a_store_is_a_zip_of_texts_and_chunks() {
        let dimensions = vec![("chain".to_owned(), 1), ("draw".to_owned(), 2)];
        let lp = Array { name: "lp".to_owned(), dimensions, values: Values::Numbers(vec![1.0, 2.0]) };
        let none = Array {
            name: "none".to_owned(),
            dimensions: vec![("none".to_owned(), 0)],
            values: Values::Numbers(Vec::new()),
        };
        let groups = vec![ZarrGroup { name: "sample_stats".to_owned(), arrays: vec![lp, none] }];
        let store = Store { attributes: Map::new(), groups };
        let bytes = store.zipped().unwrap();
        assert_eq!(bytes, store.zipped().unwrap());
        let zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        let names: Vec<String> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
        for name in [".zgroup", ".zmetadata", "sample_stats/lp/.zarray", "sample_stats/lp/0.0"] {
            assert!(names.iter().any(|own| own == name), "{names:?}");
        }
        assert!(!names.iter().any(|name| name.starts_with("sample_stats/none/0")), "{names:?}");
    }
}
