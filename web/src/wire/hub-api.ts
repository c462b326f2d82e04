/** The hub's HTTP interface as functions. */

import { msg, str } from "@lit/localize";
import type { AnomalyList, DeviceList, DeviceSummary, EventList, HistoryAnswer, LearnAnswer, Me, OidcAnswer, OidcDone, OidcProvider, OidcStart, OutlierList, PasskeyOptions, SiteShape, SiteSummary, SkyFieldShape, SkyList, StatisticsList, StoredList, StoredShape, ValueList } from "../generated/api.js";
import { hubText, inPageLanguage } from "../words/hub-text.js";

/** The hub answered, and the answer was no. */
export class Refused extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    message: string,
    /** Seconds until another try makes sense; 0 when the hub did not say. */
    readonly retryAfter = 0,
  ) {
    super(message);
  }
}

/** The hub did not answer. */
export class Unreachable extends Error {}

/** A stretch of time: µs since the epoch, UTC. */
export interface TimeWindow {
  readonly fromUs: number;
  readonly toUs: number;
}

/** What is asked of a chart's window. */
export interface HistoryQuery extends TimeWindow {
  readonly channels: readonly string[];
  /** Pixels; at most two points come for each. */
  readonly width: number;
}

export type HttpMethod = "GET" | "POST" | "PUT" | "PATCH" | "DELETE";

/** With this header a question does not count as the person's doing: the session's idle time goes on. */
const BACKGROUND = { "talaia-background": "1" } as const;

/** What is said besides the question itself. */
export interface RequestOptions {
  readonly signal?: AbortSignal | undefined;
  /** Whether the page asks by itself; when not said, everything that changes nothing is taken so. */
  readonly background?: boolean;
  /** Whether the answer is bytes, and no JSON. */
  readonly bytes?: boolean;
  /** Is given the headers of a good answer. */
  readonly onHeaders?: (headers: Headers) => void;
}

/** What the hubs that can be reached say of their sites, and the names of those that cannot. */
export interface SiteRows {
  readonly rows: readonly SiteSummary[];
  readonly missing: readonly string[];
}

export class HubApi {
  /** Asks the person for their password anew; gives whether the hub has taken it. */
  confirmPerson: (() => Promise<boolean>) | null = null;
  /**
   * The hub knows nobody here any more: the session is over. Gives, once somebody has signed in or left, whether
   * the same may be asked once more.
   */
  onSignedOut: (() => Promise<boolean>) | null = null;

  constructor(private readonly fetcher: typeof fetch = fetch.bind(globalThis)) {}

  /**
   * Who is signed in; null when nobody is.
   *
   * @param background false: the person asks, and the session lives longer for it
   */
  async currentPerson(background = true): Promise<Me | null> {
    try {
      return await this.request<Me>("GET", "/api/me", undefined, { background });
    } catch (error) {
      if (error instanceof Refused && error.status === 401) return null;
      throw error;
    }
  }

  /** @param code the second factor's six digits, or a recovery code; empty when none was asked for */
  login(name: string, password: string, code = ""): Promise<Me> {
    return this.request("POST", "/api/login", code === "" ? { name, password } : { name, password, code });
  }

  /** What a passkey has to answer: in place of name and password, or after both. */
  async passkeySignIn(name = "", password = ""): Promise<Readonly<Record<string, unknown>>> {
    const said = name === "" ? {} : { name, password };
    return (await this.request<PasskeyOptions>("POST", "/api/login/passkey/options", said)).options;
  }

  /** @param credential the passkey's answer */
  loginByPasskey(credential: Readonly<Record<string, unknown>>): Promise<Me> {
    return this.request("POST", "/api/login/passkey", { credential });
  }

  /** By which provider one can sign in; empty when there is none. */
  async provider(): Promise<string> {
    return (await this.request<OidcProvider>("GET", "/api/login/oidc")).label;
  }

  /**
   * Begins a sign-in at the provider; gives where the browser has to go.
   *
   * @param path what for: to sign in, to confirm that it is you, or to connect one's account
   * @param returns the page to come back to
   */
  async beginOidc(path: "/api/login/oidc" | "/api/me/oidc/confirm" | "/api/me/oidc/connect", returns: string): Promise<string> {
    return (await this.request<OidcStart>("POST", path, { returns })).url;
  }

  /** Comes back from the provider. */
  finishOidc(answer: OidcAnswer): Promise<OidcDone> {
    return this.request("POST", "/api/login/oidc/finish", answer);
  }

  async logout(): Promise<void> {
    await this.request("POST", "/api/logout", {});
  }

  async setUpAdmin(token: string, name: string, password: string): Promise<void> {
    await this.request("POST", "/api/setup", { token, name, password });
  }

  async sites(): Promise<readonly SiteSummary[]> {
    return (await this.siteRows()).rows;
  }

  /** As `sites`; where several hubs divide the sites among them, one may be away. */
  async siteRows(): Promise<SiteRows> {
    let missing = "";
    const onHeaders = (headers: Headers): void => {
      missing = headers.get("x-talaia-missing") ?? "";
    };
    const rows = await this.request<readonly SiteSummary[]>("GET", "/api/sites", undefined, { onHeaders });
    return { rows, missing: missing === "" ? [] : missing.split(",") };
  }

  site(site: string): Promise<SiteShape> {
    return this.request("GET", `/api/sites/${encodeURIComponent(site)}`);
  }

  /** Every device that is open to the person, of every site. */
  async devices(): Promise<readonly DeviceSummary[]> {
    return (await this.request<DeviceList>("GET", "/api/devices")).devices;
  }

  history(site: string, query: HistoryQuery, signal?: AbortSignal): Promise<HistoryAnswer> {
    const search = windowQuery(query, query.channels);
    search.set("width", String(Math.round(query.width)));
    const path = `/api/sites/${encodeURIComponent(site)}/history?${search.toString()}`;
    return this.request("GET", path, undefined, { signal });
  }

  /** The last sample of each channel before a moment (µs); those without are left out. */
  lastValues(site: string, channels: readonly string[], beforeUs: number, signal?: AbortSignal): Promise<ValueList> {
    const search = new URLSearchParams({ before_us: String(Math.floor(beforeUs)) });
    for (const channel of channels) search.append("channel", channel);
    return this.request("GET", `/api/sites/${encodeURIComponent(site)}/last?${search.toString()}`, undefined, { signal });
  }

  /** What a window (µs) amounts to, of every sample in it. */
  statistics(site: string, channels: readonly string[], span: TimeWindow, signal?: AbortSignal): Promise<StatisticsList> {
    const search = windowQuery(span, channels);
    return this.request("GET", `/api/sites/${encodeURIComponent(site)}/statistics?${search.toString()}`, undefined, { signal });
  }

  /** The quartiles of a window (µs), of every sample in it, and how many lie `k` times their distance beyond them. */
  outliers(site: string, channels: readonly string[], span: TimeWindow, k: number, signal?: AbortSignal): Promise<OutlierList> {
    const search = windowQuery(span, channels);
    search.set("k", String(k));
    return this.request("GET", `/api/sites/${encodeURIComponent(site)}/outliers?${search.toString()}`, undefined, { signal });
  }

  /** What goes by a name in the hub's catalogue of the sky. */
  searchSky(site: string, name: string): Promise<SkyList> {
    const query = new URLSearchParams({ name }).toString();
    return this.request("GET", `/api/sites/${encodeURIComponent(site)}/sky?${query}`);
  }

  /** Stars and outlines within a radius of a place (°, J2000). */
  skyField(site: string, { raDeg, decDeg }: { readonly raDeg: number; readonly decDeg: number }, radius: number): Promise<SkyFieldShape> {
    const query = new URLSearchParams({ ra: String(raDeg), dec: String(decDeg), radius: String(radius) }).toString();
    return this.request("GET", `/api/sites/${encodeURIComponent(site)}/sky/field?${query}`);
  }

  /** Channels that have history and that the site's description no longer has. */
  async formerChannels(site: string): Promise<readonly StoredShape[]> {
    const path = `/api/sites/${encodeURIComponent(site)}/stored?former=true`;
    return (await this.request<StoredList>("GET", path)).channels;
  }

  /** Why no such file would be given, by asking for a microsecond of it; empty where nothing stands against it. */
  async exportRefusal(site: string, query: ExportQuery): Promise<string> {
    const least = { ...query, toUs: query.fromUs + 1, width: 0 };
    try {
      const response = await this.fetcher(exportPath(site, least), { credentials: "same-origin" });
      if (!response.ok) return (await refusalOf(response)).message;
      await response.body?.cancel();
      return "";
    } catch {
      return msg("The hub does not answer.");
    }
  }

  /** The anomaly detectors of a site, and what each says now. */
  anomalies(site: string): Promise<AnomalyList> {
    return this.request("GET", `/api/sites/${encodeURIComponent(site)}/anomalies`);
  }

  /** Says that a detector's latest peak was no anomaly; gives whether it learned. */
  async dismissAnomaly(site: string, address: string, detector: string): Promise<boolean> {
    const path = `/api/sites/${encodeURIComponent(site)}/anomalies/forgiven`;
    return (await this.request<{ learned: boolean }>("POST", path, { address, detector })).learned;
  }

  /** Lets a group of signals learn what is usual from a stretch of the history. */
  learnUsual(site: string, address: string, { fromUs, toUs }: TimeWindow, comment = ""): Promise<LearnAnswer> {
    const path = `/api/sites/${encodeURIComponent(site)}/anomalies/learned`;
    return this.request("POST", path, { address, from_us: fromUs, to_us: toUs, comment });
  }

  /** What happened in a window (µs), newest first. */
  events(site: string, span: TimeWindow, limit: number, signal?: AbortSignal): Promise<EventList> {
    const search = windowQuery(span);
    search.set("limit", String(limit));
    return this.request("GET", `/api/sites/${encodeURIComponent(site)}/events?${search.toString()}`, undefined, { signal });
  }

  /**
   * Asks the hub for anything; what is asked for often has a function of its own.
   *
   * What gives rights away the hub does only after the password was given a short while ago: the person is asked
   * for it, and then the same is asked once more. So is what a page only wanted to know, when the session turned
   * out to be over and the person has signed in again.
   *
   * @throws Refused when the hub says no
   * @throws Unreachable when there is no hub, or something else answers in its place
   */
  async request<T>(method: HttpMethod, path: string, body?: object, options: RequestOptions = {}): Promise<T> {
    try {
      return await this.requestOnce<T>(method, path, body, options);
    } catch (error) {
      // A wrong password is answered with 401, too, and a wrong code: only this says that nobody is signed in.
      if (error instanceof Refused && error.code === "unauthorized" && path !== "/api/me" && path !== "/api/login") {
        const back = this.onSignedOut?.() ?? Promise.resolve(false);
        // What changes something is not done minutes later, when its moment may be over: the person does it again.
        if (method !== "GET") throw new Refused(401, error.code, msg("You were signed out; nothing was done. Do it once more."));
        if (!(await back)) throw error;
        return await this.requestOnce<T>(method, path, body, options);
      }
      if (!(error instanceof Refused) || error.code !== "confirm" || this.confirmPerson === null) throw error;
      if (!(await this.confirmPerson())) {
        throw new Refused(403, "confirm", msg("You did not confirm that it is you; nothing was changed."));
      }
      return await this.requestOnce<T>(method, path, body, options);
    }
  }

  /** Asks for bytes; otherwise as `request`. */
  async requestBytes(path: string, { signal }: Pick<RequestOptions, "signal"> = {}): Promise<ArrayBuffer> {
    return this.request<ArrayBuffer>("GET", path, undefined, { signal, bytes: true });
  }

  private async requestOnce<T>(
    method: HttpMethod,
    path: string,
    body: object | undefined,
    options: RequestOptions,
  ): Promise<T> {
    // A touch of the page keeps the session (state/touched.ts); what pages ask for again and again does not.
    const { signal, background = method === "GET", bytes = false } = options;
    const headers = new Headers({ accept: bytes ? "application/msgpack" : "application/json", ...(background ? BACKGROUND : {}) });
    const request: RequestInit = { method, credentials: "same-origin", headers };
    if (signal !== undefined) request.signal = signal;
    if (body !== undefined) {
      request.body = JSON.stringify(body);
      headers.set("content-type", "application/json");
    }
    let response: Response;
    try {
      response = await this.fetcher(path, request);
    } catch (error) {
      if (signal?.aborted === true) throw error;
      throw new Unreachable(msg("The hub does not answer."), { cause: error });
    }
    if (response.ok) options.onHeaders?.(response.headers);
    if (response.ok && bytes) return (await response.arrayBuffer()) as T;
    if (response.ok) return (response.status === 204 ? undefined : inPageLanguage(await response.json())) as T;
    if (response.status === 502 || response.status === 503 || response.status === 504) {
      throw new Unreachable(msg("The hub is not ready."));
    }
    throw await refusalOf(response);
  }
}

function windowQuery({ fromUs, toUs }: TimeWindow, channels: readonly string[] = []): URLSearchParams {
  const search = new URLSearchParams(channels.map((channel) => ["channel", channel]));
  search.set("from_us", String(Math.max(0, Math.round(fromUs))));
  search.set("to_us", String(Math.round(toUs)));
  return search;
}

/** Where a file with a window's samples is to be had. */
export interface ExportQuery extends HistoryQuery {
  readonly format: "csv" | "parquet" | "arrow";
}

/** The address of a file of samples; `width` 0 for every sample, else what so many pixels show. */
export function exportPath(site: string, query: ExportQuery): string {
  const search = windowQuery(query, query.channels);
  search.set("format", query.format);
  if (query.width > 0) search.set("width", String(Math.round(query.width)));
  return `/api/sites/${encodeURIComponent(site)}/export?${search.toString()}`;
}

/** Why the hub refuses, in words for people. */
export async function refusalOf(response: Response): Promise<Refused> {
  const retryAfter = Number(response.headers.get("retry-after") ?? "0") || 0;
  let said: unknown = null;
  try {
    said = await response.json();
  } catch {
    // No JSON: the status alone has to speak.
  }
  const { code, message } = (said ?? {}) as { code?: unknown; message?: unknown };
  return new Refused(
    response.status,
    typeof code === "string" ? code : "unknown",
    typeof message === "string" ? hubText(message) : msg(str`The hub answered ${String(response.status)}.`),
    retryAfter,
  );
}
