/**
 * The container of a GLB file: a 12-byte header, then chunks with an 8-byte header each. All
 * numbers are 32-bit little-endian.
 * @module
 */

/** The glTF extension of files with a stream. */
export const EXTENSION = 'TRISTRIP_progressive';

/** The magic number of a file, and the types of its chunks. */
export const MAGIC = 0x46546c67;
export const JSON_CHUNK = 0x4e4f534a;
export const BIN_CHUNK = 0x004e4942;

/**
 * The size of the file header (magic, version, file length) and of a chunk header (length, type).
 */
export const HEADER_BYTES = 12;
export const CHUNK_HEADER_BYTES = 8;
/** The offset of the JSON. */
export const JSON_START = HEADER_BYTES + CHUNK_HEADER_BYTES;
