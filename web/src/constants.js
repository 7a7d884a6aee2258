/**
 * The numbers that the format fixes. An encoder and a decoder that differ in one of them do not understand each other.
 * @module
 */

/** The number of which probabilities are shares. */
export const WHOLE = 1 << 16;
/** The range of the coder is at least this. */
export const MIN_RANGE = 1 << 24;
/** Zeros at the end of a payload that are left out, at most. */
export const MAX_TRIMMED = 4;

/** A slot counts up to this. */
export const MAX_COUNT = 255;

/** The exponentials of scores, from e⁰ to e⁻⁸. */
export const FALLS_LENGTH = 256;
/** How slowly scores move: by one part in two to this power of an error. */
export const SCORE_RATE = 4;

/** The levels of numbers that have symbols of their own, from −2 on in quarters of an octave. */
export const LEVELS = 80;
/** The symbol of the usual bucket, and the last one. */
export const MIDDLE_SYMBOL = 9;
export const LAST_SYMBOL = 15;
/** The largest bucket. */
export const MAX_BUCKET = 59;
/** The contexts of small numbers, and the bits of the largest one. */
export const SMALL_CONTEXTS = 32;
export const MAX_SMALL_BITS = 25;

/** A fan of more corners is not split. */
export const MAX_CORNERS = 1024;
/** The fans of a point among which one is chosen. */
export const MAX_TWINS = 1024;
/** The features of a mark: valence and free corners; then ages; then the distance from the mean. */
export const AGE_FEATURES = 16 * 8 * 4;
export const DISTANCE_FEATURES = AGE_FEATURES + 8;
export const MARK_FEATURES = DISTANCE_FEATURES + 32;
/** The roles of an edge; its lengths, and the valences at its other end, of which the first one stands for a border. */
export const ROLES = 3;
export const LENGTHS = 16;
export const VALENCES = 16;
/** A fan of more corners has no choices by scores. */
export const MAX_CHOICES = 15;

/** The estimates beside the mean of the polygon. */
export const ESTIMATES = 4;
/** The largest Laplacian. */
export const MAX_LAPLACIAN = 1 << 21;
/** The numbers of points that have weights of their own: 3, 4, 5, 6, 7, and more. */
export const POLYGONS = 6;
/** The batches that have weights of their own: the last, the last but one, and all before. */
export const REGIMES = 3;
/** The weight one. */
export const WEIGHT_ONE = 64;
/** The usual weights of each estimate along the normal and beside it. */
export const USUAL_WEIGHTS = [42, 13, -6, -12, 12, 14, 32, 52];
/** The first weights of the features of a level, beside the normal and along it, and of attributes. */
export const BESIDE_LEVEL = [55000, 40000, 29000, 42000, 13000];
export const ALONG_LEVEL = [36000, 6000, 6000, 9000, 3000];
export const CHANNEL_LEVEL = [-8000, 50000, 10000];
/** The square length of the sides of triangles that are not known. */
export const USUAL_SQUARE = 1 << 24;

/** The components that have contexts of their own. */
export const MAX_AXES = 4;

/** What a head may say. */
export const MAX_BITS = 16;
export const MAX_CHANNELS = 64;
export const MAX_NAME_BYTES = 256;
export const MAX_CHANNEL_BITS = 24;
/** The most bytes of the head of a chunk, with its checksum. */
export const MAX_HEAD_BYTES = 5 * 5 + 4 + 4;
