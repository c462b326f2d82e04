/** Shapes of accounts, roles, gateways and the audit log, by the names the pages use. */

export type {
  AuditChain as AuditCheck,
  AuditList as AuditPage,
  AuditRow,
  CodeShape as CodeMade,
  FactorOffer,
  GatewayList,
  GatewayShape as GatewayRow,
  NewToken as TokenMade,
  OpenCodeShape as CodeRow,
  PersonShape as PersonRow,
  RoleShape as RoleRow,
  SessionShape as SessionRow,
  TokenShape as TokenRow,
} from "../generated/api.js";
