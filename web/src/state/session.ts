/** Who is signed in. */

import type { Person } from "../wire/api.js";
import type { HubApi } from "../wire/http.js";
import { Store } from "./store.js";

/**
 * - `unknown`: not asked yet
 * - `nobody`: the hub knows nobody here
 * - `known`: `person` says who
 */
export type SessionState = "unknown" | "nobody" | "known";

export class Session extends Store {
  private someone: Person | null = null;
  private asked = false;

  constructor(private readonly api: HubApi) {
    super();
  }

  get state(): SessionState {
    if (!this.asked) return "unknown";
    return this.someone === null ? "nobody" : "known";
  }

  get person(): Person | null {
    return this.someone;
  }

  /** Why the last session ended, for the sign-in page; empty when nobody needs to be told. */
  notice = "";

  /** Asks the hub who we are. @throws Unreachable */
  async refresh(): Promise<void> {
    this.become(await this.api.me());
  }

  /** @throws Refused, Unreachable */
  async login(name: string, password: string): Promise<void> {
    const person = await this.api.login(name, password);
    this.notice = "";
    this.become(person);
  }

  /** Nobody is signed in afterwards, also when the hub could not be told. */
  async logout(): Promise<void> {
    try {
      await this.api.logout();
    } finally {
      this.notice = "";
      this.become(null);
    }
  }

  private become(person: Person | null): void {
    const same = this.asked && person?.name === this.someone?.name && person?.role === this.someone?.role;
    this.asked = true;
    this.someone = person;
    if (!same) this.changed();
  }
}
