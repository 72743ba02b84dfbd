//! Results of studies.

use super::Bench;

const STUDY: &str = "worlds = \"environment-1\"\nplants = \"point\"\nmax_steps = 2\nseeds = 1\n";

/// A row of results with values of its own, and the checksum that a sweep would write.
fn row(header: &[&str], line: &str, set: &[(&str, String)]) -> String {
    let mut cells: Vec<String> = line.trim_end().split(',').map(str::to_owned).collect();
    for (column, value) in set {
        cells[header.iter().position(|name| name == column).expect("a column")].clone_from(value);
    }
    let checksum = header.iter().position(|name| *name == "checksum").expect("a checksum");
    let (begin, end) =
        (cells[..checksum].join(",") + ",", ",".to_owned() + &cells[checksum + 1..].join(",") + "\n");
    let sum = crc32fast::hash((begin.clone() + &end).as_bytes());
    format!("{begin}{sum:08x}{end}")
}

/// The header and the row of a small study.
fn results(bench: &Bench) -> (String, String) {
    bench.write("s.toml", STUDY);
    bench.reads("sweep s.toml -o rows.csv");
    let text = std::fs::read_to_string(bench.path("rows.csv")).unwrap();
    let (header, line) = text.split_once('\n').expect("a row");
    assert_eq!(row(&header.split(',').collect::<Vec<_>>(), line, &[]), line, "the checksum is the program's");
    (header.to_owned(), line.to_owned())
}

pub(super) fn rows(bench: Bench) {
    let (header, line) = results(&bench);
    let names: Vec<&str> = header.split(',').collect();
    // every row a combination of its own
    let mut text = header.clone() + "\n";
    let count = bench.longest() / (line.len() + 30);
    for i in 0..count {
        let set = [("episode", i), ("episodes", count), ("eta", i + 1), ("seed", i)];
        text += &row(&names, &line, &set.map(|(name, value)| (name, value.to_string())));
    }
    assert!(text.len() < bench.longest() && text.len() > bench.longest() / 10 * 8);
    bench.write("rows.csv", &text);
    bench.reads("sweep --summary rows.csv");
    // a line that is longer than any
    let long = row(&names, &line, &[("world", "x".repeat(64 << 10))]);
    bench.write("rows.csv", format!("{header}\n{long}"));
    for command in ["sweep --summary rows.csv", "sweep --merge out.csv rows.csv"] {
        bench.refuses(command, "a line is longer than 65536 bytes");
    }
    // a million columns
    bench.write("rows.csv", header + &",x".repeat(1_000_000));
    bench.refuses("sweep --summary rows.csv", "a line is longer than 65536 bytes");
}

#[cfg(not(feature = "parquet"))]
pub(super) fn columns(bench: Bench) {
    bench.write("rows.parquet", b"PAR1");
    bench.refuses("sweep --summary rows.parquet", "without the feature `parquet`");
}

#[cfg(feature = "parquet")]
pub(super) use columnar::columns;

#[cfg(feature = "parquet")]
mod columnar {
    use super::{Bench, results};
    use arrow_array::{ArrayRef, RecordBatch, StringArray};
    use parquet::arrow::ArrowWriter;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use parquet::basic::{Compression, Encoding};
    use parquet::file::properties::WriterProperties;
    use std::fs::File;
    use std::path::Path;
    use std::sync::Arc;

    /// Writes a batch many times.
    fn write(path: &Path, batch: &RecordBatch, count: usize, properties: WriterProperties) {
        let file = File::create(path).unwrap();
        let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties)).unwrap();
        (0..count).for_each(|_| writer.write(batch).unwrap());
        writer.close().unwrap();
    }

    /// The batch with another world in all its rows.
    fn with_world(batch: &RecordBatch, world: &str) -> RecordBatch {
        let column = batch.schema().index_of("world").unwrap();
        let mut columns = batch.columns().to_vec();
        let cells = vec![world; batch.num_rows()];
        columns[column] = Arc::new(StringArray::from(cells)) as ArrayRef;
        RecordBatch::try_new(batch.schema(), columns).unwrap()
    }

    fn packed() -> parquet::file::properties::WriterPropertiesBuilder {
        WriterProperties::builder().set_compression(Compression::ZSTD(Default::default()))
    }

    pub fn columns(bench: Bench) {
        results(&bench);
        bench.reads("sweep s.toml -o rows.parquet");
        let file = File::open(bench.path("rows.parquet")).unwrap();
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).unwrap().build();
        let batch = reader.unwrap().next().unwrap().unwrap();
        let path = bench.path("many.parquet");
        // few bytes for many rows
        write(&path, &batch, 200_000, packed().build());
        assert!(path.metadata().unwrap().len() < bench.bounds.bytes());
        bench.run("sweep --summary many.parquet");
        // a value of a megabyte that a dictionary repeats, and that another encoding repeats
        let long = with_world(&batch, &"x".repeat(1_000_000));
        write(&path, &long, 2000, packed().set_dictionary_page_size_limit(1 << 30).build());
        assert!(path.metadata().unwrap().len() < 1 << 20, "{}", path.metadata().unwrap().len());
        bench.run("sweep --summary many.parquet");
        let delta = packed().set_dictionary_enabled(false).set_encoding(Encoding::PLAIN);
        let delta = delta.set_column_encoding("world".into(), Encoding::DELTA_BYTE_ARRAY);
        write(&path, &long, 500, delta.build());
        bench.refuses("sweep --summary many.parquet", "DELTA_BYTE_ARRAY");
        // a page that is longer than any
        let long = with_world(&batch, &"x".repeat(17 << 20));
        write(&path, &long, 1, packed().set_dictionary_enabled(false).build());
        assert!(path.metadata().unwrap().len() < 1 << 20);
        bench.refuses("sweep --summary many.parquet", "length of a page");
        // a description that is longer than any
        let mut bytes = vec![0; 9 << 20];
        bytes[..4].copy_from_slice(b"PAR1");
        bytes.extend(((9_u32 << 20) - 4).to_le_bytes());
        bytes.extend(b"PAR1");
        std::fs::write(&path, bytes).unwrap();
        bench.refuses("sweep --summary many.parquet", "length of the file's description");
    }
}
