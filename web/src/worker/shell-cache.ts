/** What the service worker may keep and give: files of the pages by their hash, never anything of the hub. Pure. */

/** The caches of ours begin so; behind it is the version of the pages. */
export const CACHE_PREFIX = "talaia-shell-";

/** Given in place of a page when the hub cannot be reached. */
export const OFFLINE_PAGE = "/offline.html";

/** What is below these comes from the hub itself: data, sockets, files of others. */
const HUB_PATHS = /^\/(?:api|ws|extensions|gateway)(?:\/|$)/;

/** The fields of a `Request` that decide. */
export interface AskedFile {
  readonly method: string;
  readonly mode: string;
  readonly url: string;
}

/**
 * - `page`: from the hub; the offline page where there is none
 * - `hashed`: its name holds a hash of its content, so what is kept is never old
 * - `plain`: from the hub first; what is kept only where there is none
 * - `hub`: not the worker's business
 */
export type FileHandling = "page" | "hashed" | "plain" | "hub";

/** How a request is answered. @param kept - paths of the shell's files */
export function handlingOf({ method, mode, url }: AskedFile, origin: string, kept: ReadonlySet<string>): FileHandling {
  if (method !== "GET" || !URL.canParse(url)) return "hub";
  const { origin: from, pathname, search } = new URL(url);
  if (from !== origin || HUB_PATHS.test(pathname)) return "hub";
  if (mode === "navigate") return "page";
  if (search !== "") return "hub";
  if (isHashed(pathname)) return "hashed";
  return kept.has(pathname) ? "plain" : "hub";
}

/** Whether a file's name holds a hash of its content. */
export function isHashed(path: string): boolean {
  return path.startsWith("/assets/");
}

/** The fields of a `Response` that decide. */
export interface AnsweredFile {
  readonly status: number;
  readonly type: string;
  readonly redirected: boolean;
  readonly headers: { get(name: string): string | null };
}

/** Only what the hub itself says never changes is kept; an answer in its place (a proxy's, a sign-in page) is not. */
export function mayKeep({ status, type, redirected, headers }: AnsweredFile): boolean {
  return status === 200 && type === "basic" && !redirected && (headers.get("Cache-Control") ?? "").includes("immutable");
}

/**
 * The caches that are not needed any more. The one before the current stays: pages that were
 * opened before an update still fetch parts of their own version.
 *
 * @param names - all of this origin, the oldest first
 */
export function expiredCaches(names: readonly string[], current: string): readonly string[] {
  const former = names.filter((name) => name.startsWith(CACHE_PREFIX) && name !== current);
  return former.slice(0, -1);
}
