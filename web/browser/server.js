/**
 * A static HTTP server for tests with a simulated network: slow, interrupted, or with bit errors.
 * @module
 */
import { createHash } from 'node:crypto';
import { createReadStream } from 'node:fs';
import { readFile, stat } from 'node:fs/promises';
import http from 'node:http';
import path from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';

/** @type {Record<string, string>} */
const TYPES = {
  '.css': 'text/css',
  '.glb': 'model/gltf-binary',
  '.gltf': 'model/gltf+json',
  '.html': 'text/html; charset=utf-8',
  '.jpg': 'image/jpeg',
  '.js': 'text/javascript',
  '.json': 'application/json',
  '.mjs': 'text/javascript',
  '.png': 'image/png',
  '.svg': 'image/svg+xml',
};

/** The number of writes per second on a slow network. */
const TICKS_PER_SECOND = 50;

/**
 * The delivery of a file.
 * @typedef {object} Network
 * @property {number} [bytesPerSecond] by default unlimited
 * @property {number} [dropAfter] close the connection after this many bytes of the file
 * @property {number} [drops] how often to drop, by default once
 * @property {number} [holdAfter] send no more bytes of the file until `hold` raises it
 * @property {number} [flipAt] flip a bit of this byte of the file
 * @property {number} [status] an HTTP status instead of the file
 */

/**
 * A request for a file.
 * @typedef {object} Request
 * @property {string} path
 * @property {string} [range]
 */

/** Serves directories on a free local port. */
export class Server {
  #folders;
  #server = http.createServer((request, response) => void this.#answer(request, response));
  /** @type {Map<string, Network>} */
  #networks = new Map();
  /**
   * All requests so far.
   * @type {Request[]}
   */
  requests = [];

  /**
   * @param {Record<string, string | URL>} folders from path prefixes such as `/models/` to
   *   directories; longer prefixes take precedence
   */
  constructor(folders) {
    this.#folders = Object.entries(folders).sort(([a], [b]) => b.length - a.length);
  }

  /** @returns {Promise<this>} */
  async start() {
    await new Promise((resolve) => this.#server.listen(0, '127.0.0.1', () => resolve(undefined)));
    return this;
  }

  /** The origin of URLs, without a trailing slash. */
  get origin() {
    const { port } = /** @type {import('node:net').AddressInfo} */ (this.#server.address());
    return `http://127.0.0.1:${port}`;
  }

  /** Closes all connections. */
  close() {
    this.#server.closeAllConnections();
    this.#server.close();
  }

  /**
   * Sets the delivery of a file.
   * @param {string} file its URL path
   * @param {Network} [network]
   */
  shape(file, network = {}) {
    this.#networks.set(file, { drops: 1, ...network });
  }

  /**
   * Sets how many bytes of a file may be sent until the next call. Also applies to active
   * responses.
   * @param {string} file its URL path
   * @param {number} [bytes] by default all
   */
  hold(file, bytes = Infinity) {
    const network = this.#networks.get(file) ?? { drops: 1 };
    network.holdAfter = bytes;
    this.#networks.set(file, network);
  }

  /**
   * Returns the requests for a file.
   * @param {string} file its URL path
   */
  requestsOf(file) {
    return this.requests.filter((request) => request.path === file);
  }

  /**
   * @param {http.IncomingMessage} request
   * @param {http.ServerResponse} response
   */
  async #answer(request, response) {
    try {
      await this.#send(request, response);
    } catch {
      if (!response.headersSent) response.writeHead(404);
      response.end();
    }
  }

  /**
   * @param {http.IncomingMessage} request
   * @param {http.ServerResponse} response
   */
  async #send(request, response) {
    const url = decodeURIComponent(new URL(request.url ?? '/', 'http://localhost').pathname);
    if (url === '/favicon.ico') return void response.writeHead(204).end();
    const file = this.#find(url);
    const { range, 'if-range': ifRange } = request.headers;
    this.requests.push({ path: url, ...(range && { range }) });
    const network = this.#networks.get(url) ?? {};
    if (network.status) return void response.writeHead(network.status).end();
    const { size, mtimeMs } = await stat(file);
    const etag = `"${createHash('sha256').update(`${file} ${size} ${mtimeMs}`).digest('hex').slice(0, 16)}"`;
    const asked = /^bytes=(\d+)-(\d*)$/.exec(range ?? '');
    const isPart = asked !== null && (ifRange === undefined || ifRange === etag);
    const start = isPart ? Number(asked[1]) : 0;
    const end = isPart && asked[2] ? Math.min(Number(asked[2]) + 1, size) : size;
    if (start >= size && size > 0) return void response.writeHead(416, { 'content-range': `bytes */${size}` }).end();
    response.writeHead(isPart ? 206 : 200, {
      'content-type': TYPES[path.extname(file)] ?? 'application/octet-stream',
      'content-length': end - start,
      'accept-ranges': 'bytes',
      'cache-control': 'no-cache',
      etag,
      ...(isPart && { 'content-range': `bytes ${start}-${end - 1}/${size}` }),
    });
    if (request.method === 'HEAD' || size === 0) return void response.end();
    if (!this.#networks.has(url)) return void createReadStream(file, { start, end: end - 1 }).pipe(response);
    await this.#sendSlowly((await readFile(file)).subarray(0, end), start, network, response);
  }

  /** @param {string} url */
  #find(url) {
    const [start, folder] = this.#folders.find(([start]) => url.startsWith(start)) ?? ['', ''];
    const root = folder instanceof URL ? folder.pathname : folder;
    const file = path.join(root, url.slice(start.length));
    if (!root || !path.resolve(file).startsWith(path.resolve(root))) throw new Error(`no folder for ${url}`);
    return file.endsWith('/') ? `${file}index.html` : file;
  }

  /**
   * @param {Uint8Array} bytes the file, up to the last requested byte
   * @param {number} start
   * @param {Network} network
   * @param {http.ServerResponse} response
   */
  async #sendSlowly(bytes, start, network, response) {
    const { flipAt, bytesPerSecond = Infinity } = network;
    const sent = Uint8Array.from(bytes);
    if (flipAt !== undefined && flipAt < sent.length) sent[flipAt] ^= 1;
    const step = Math.ceil(bytesPerSecond / TICKS_PER_SECOND);
    for (let at = start; at < sent.length && !response.destroyed; ) {
      const { dropAfter = Infinity, drops = 0, holdAfter = Infinity } = network;
      const isDropped = drops > 0 && Number.isFinite(dropAfter) && at + step >= dropAfter;
      const end = Math.min(at + step, sent.length, Math.max(holdAfter, at), isDropped ? Math.max(dropAfter, at) : Infinity);
      if (end === at && !isDropped) {
        await sleep(1000 / TICKS_PER_SECOND);
        continue;
      }
      await new Promise((resolve) => response.write(sent.subarray(at, end), resolve));
      at = end;
      if (isDropped) {
        network.drops = drops - 1;
        await sleep(10);
        response.destroy();
        return;
      }
      if (step !== Infinity) await sleep(1000 / TICKS_PER_SECOND);
    }
    response.end();
  }
}
