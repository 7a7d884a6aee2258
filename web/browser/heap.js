/**
 * The memory of a page and its workers after garbage collection.
 * @module
 */

/**
 * Returns the bytes of JavaScript objects and typed arrays in a page and its first worker.
 * @param {import('playwright-core').Page} page with one worker
 * @returns {Promise<{ page: number, worker: number }>}
 */
export async function heapOf(page) {
  const session = await page.context().newCDPSession(page);
  const send = (/** @type {any} */ method, /** @type {any} */ params) => session.send(method, params);
  const bytes = (/** @type {any} */ { usedSize, backingStorageSize = 0 }) => usedSize + backingStorageSize;
  await send('HeapProfiler.collectGarbage', {});
  const ofPage = bytes(await send('Runtime.getHeapUsage', {}));

  const attached = new Promise((resolve) => session.once('Target.attachedToTarget', resolve));
  await send('Target.setAutoAttach', { autoAttach: true, waitForDebuggerOnStart: false, flatten: false });
  const { sessionId } = await attached;
  /** Sends a command to the worker, and returns its result. @type {(id: number, method: string) => Promise<any>} */
  const ask = (id, method) =>
    new Promise((resolve) => {
      session.on('Target.receivedMessageFromTarget', ({ message }) => {
        const { id: answered, result } = JSON.parse(message);
        if (answered === id) resolve(result);
      });
      void send('Target.sendMessageToTarget', { sessionId, message: JSON.stringify({ id, method }) });
    });
  await ask(1, 'HeapProfiler.collectGarbage');
  const ofWorker = bytes(await ask(2, 'Runtime.getHeapUsage'));
  await session.detach();
  return { page: ofPage, worker: ofWorker };
}
