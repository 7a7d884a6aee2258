/**
 * The container of a GLB file: a header of 12 bytes, then chunks with a header of 8 bytes each. All numbers have 32 bits, the lowest byte first.
 * @module
 */

/** The name of the glTF extension of files with a stream. */
export const EXTENSION = 'TRISTRIP_progressive';

/** The first word of a file, and the types of its chunks. */
export const MAGIC = 0x46546c67;
export const JSON_CHUNK = 0x4e4f534a;
export const BIN_CHUNK = 0x004e4942;

/** The bytes of the header: magic, version, length of the file. Then those of the header of a chunk: length, type. */
export const HEADER_BYTES = 12;
export const CHUNK_HEADER_BYTES = 8;
/** Where the JSON starts. */
export const JSON_START = HEADER_BYTES + CHUNK_HEADER_BYTES;
