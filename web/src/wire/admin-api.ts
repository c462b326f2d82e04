/** What an admin may ask of the hub: people, roles, gateways, storage, the audit log. */

import type { AuditCheck, AuditPage, CodeMade, GatewayList, Outlook, PersonRow, RoleRow, StorageUse } from "./admin-types.js";
import type { Permission } from "./api-types.js";
import type { HubApi } from "./hub-api.js";

/** What of a person can be changed; what is left out stays. */
export interface PersonEdit {
  readonly role?: string;
  readonly disabled?: boolean;
  readonly password?: string;
}

const itemUrl = (path: string, id: string, more = ""): string => `/api/${path}/${encodeURIComponent(id)}${more}`;

export class AdminApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  async people(): Promise<readonly PersonRow[]> {
    return (await this.hub.request<{ people: readonly PersonRow[] }>("GET", "/api/people")).people;
  }

  addPerson(name: string, password: string, role: string): Promise<PersonRow> {
    return this.hub.request("POST", "/api/people", { name, password, role });
  }

  changePerson(person: string, change: PersonEdit): Promise<PersonRow> {
    return this.hub.request("PATCH", itemUrl("people", person), change);
  }

  async removePerson(person: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("people", person));
  }

  async endSessions(person: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("people", person, "/sessions"));
  }

  async removeFactor(person: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("people", person, "/factor"));
  }

  async roles(): Promise<readonly RoleRow[]> {
    return (await this.hub.request<{ roles: readonly RoleRow[] }>("GET", "/api/roles")).roles;
  }

  async addRole(name: string, permissions: readonly Permission[]): Promise<void> {
    await this.hub.request("POST", "/api/roles", { name, permissions });
  }

  async changeRole(role: string, name: string, permissions: readonly Permission[]): Promise<void> {
    await this.hub.request("PUT", itemUrl("roles", role), { name, permissions });
  }

  async removeRole(role: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("roles", role));
  }

  gateways(): Promise<GatewayList> {
    return this.hub.request("GET", "/api/gateways");
  }

  makeCode(site: string, name: string): Promise<CodeMade> {
    return this.hub.request("POST", "/api/gateways/codes", name === "" ? { site } : { site, name });
  }

  async withdrawCode(code: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("gateways/codes", code));
  }

  /** Its key is void and its link closed at once. */
  async revokeGateway(gateway: string): Promise<void> {
    await this.hub.request("POST", itemUrl("gateways", gateway, "/revoke"), {});
  }

  /** @param device empty: the link between gateway and hub; else the gateway's own to that device */
  async reconnect(gateway: string, device = ""): Promise<void> {
    await this.hub.request("POST", itemUrl("gateways", gateway, "/reconnect"), { device });
  }

  /** @param search the filter, as in the address; see `pages/audit/query.ts` */
  audit(search: string, signal?: AbortSignal): Promise<AuditPage> {
    return this.hub.request("GET", `/api/audit?${search}`, undefined, { signal });
  }

  storage(): Promise<StorageUse> {
    return this.hub.request("GET", "/api/storage");
  }

  /** Whether there is room for what comes; cheap, and a few minutes old. */
  storageForecast(): Promise<Outlook> {
    return this.hub.request("GET", "/api/storage/outlook");
  }

  checkAudit(): Promise<AuditCheck> {
    return this.hub.request("GET", "/api/audit/verify");
  }
}
